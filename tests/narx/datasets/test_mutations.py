"""Reading a damaged recording gives plausible angles or a one-line error that names the file.

`NARX_MUTATIONS=10000 pytest tests/narx/datasets/test_mutations.py` tries as many.
"""

import importlib.util
import os
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from narx.datasets import read_recording
from narx.errors import UserError
from narx.inference import pretrained
from narx.inference.predict import predict

_SPEC = importlib.util.spec_from_file_location(
    "mutations", Path(__file__).with_name("mutations.py")
)
mutations = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(mutations)

N = int(os.environ.get("NARX_MUTATIONS", "100"))
_CHUNK = 50
_LONGEST_S = 60.0
# a heading may accumulate many turns, but not within half a minute
_LARGEST_RAD = 100.0


@pytest.fixture(scope="module")
def method():
    return pretrained().method()


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, N, _CHUNK))
def test_a_damaged_file_ends_with_a_result_or_one_line(first, method, tmp_path):
    wrong = []
    for seed in range(first, min(first + _CHUNK, N)):
        path = mutations.damaged_file(tmp_path, seed)
        begun = time.monotonic()
        fault = _fault(path, method)
        if fault is None and time.monotonic() - begun > _LONGEST_S:
            fault = f"took {time.monotonic() - begun:.0f} s"
        if fault is not None:
            wrong.append(f"seed {seed}, {path.name}: {fault}")
        path.unlink()
    assert not wrong, "\n".join(wrong)


def _fault(path, method):
    """Describe what is wrong with the outcome of reading a file."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            prediction = predict(read_recording(path), method, where=str(path))
    except UserError as error:
        said = str(error)
        return None if "\n" not in said and path.name in said else f"message: {said!r}"
    except Exception as error:
        return repr(error)
    if len(prediction.angles_rad) != len(prediction.time_s):
        return "another number of angles than of samples"
    known = prediction.angles_rad[np.isfinite(prediction.angles_rad)]
    if known.size and np.abs(known).max() > _LARGEST_RAD:
        return f"an angle of {np.abs(known).max():g} rad"
    return None
