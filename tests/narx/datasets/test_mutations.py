"""Reading a damaged recording gives plausible angles or a one-line error that names the file.

`NARX_MUTATIONS=10000 pytest tests/narx/datasets/test_mutations.py` tries as many, of which a fifth
are data sets of several files.
"""

import importlib.util
import os
import shutil
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from narx.calibration.calibrate import calibrate
from narx.datasets import Broad, Joint1To3Dof, MotionBids, SmartphonePocket, read_recording
from narx.datasets.study import Study
from narx.errors import UserError
from narx.inference import pretrained
from narx.inference.predict import predict


def _beside(name):
    """Import a file of this folder."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


mutations = _beside("mutations")

N = int(os.environ.get("NARX_MUTATIONS", "100"))
_CHUNK = 50
_LONGEST_S = 60.0
_SETS = 5  # one of so many is a data set
# a heading may accumulate many turns, but not within half a minute
_LARGEST_RAD = 100.0


@pytest.fixture(scope="module")
def method():
    return pretrained().method()


@pytest.fixture(scope="module")
def intact(tmp_path_factory):
    """A small data set of every source."""
    root = tmp_path_factory.mktemp("intact")
    for name in ("joint_1to3dof", "broad", "motion_bids", "study"):
        (root / name).mkdir()
    _beside("test_tracked_sensor").save_joint(root / "joint_1to3dof" / "data_2D_07.mat")
    _beside("test_tracked_sensor").save_broad(root / "broad" / "99_made_up_motion.mat")
    _beside("test_smartphone_pocket").write_walk(root / "smartphone_pocket", "Ada", "iPhone5")
    _beside("test_motion_bids").write_bids(root / "motion_bids")
    _beside("test_study").write_study(root / "study")
    return {
        Broad: root / "broad",
        Joint1To3Dof: root / "joint_1to3dof",
        MotionBids: root / "motion_bids",
        SmartphonePocket: root / "smartphone_pocket",
        Study: root / "study",
    }


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, N // _SETS, _CHUNK))
def test_a_damaged_data_set_ends_with_a_trial_or_one_line(first, intact, tmp_path):
    wrong = []
    for seed in range(first, min(first + _CHUNK, N // _SETS)):
        source = list(intact)[seed % len(intact)]
        folder = tmp_path / str(seed)
        done = mutations.damaged_set(intact[source], folder, seed)
        begun = time.monotonic()
        fault = _fault_of_set(source, folder)
        if fault is None and time.monotonic() - begun > _LONGEST_S:
            fault = f"took {time.monotonic() - begun:.0f} s"
        if fault is not None:
            wrong.append(f"seed {seed}, {source.__name__}, {done}: {fault}")
        shutil.rmtree(folder)
    assert not wrong, "\n".join(wrong)


def _fault_of_set(source, folder):
    """Describe what is wrong with the outcome of reading a data set."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            trial = next(iter(source(root=folder)))
            calibrated = calibrate(trial)
    except UserError as error:
        said = str(error)
        return None if "\n" not in said else f"message: {said!r}"
    except Exception as error:
        return repr(error)
    for segment, one in calibrated.items():
        known = one.signals.axis_rates_rad_s[np.isfinite(one.signals.axis_rates_rad_s)]
        if known.size and np.abs(known).max() > _LARGEST_RAD:
            return f"{segment}: {np.abs(known).max():g} rad/s"
    return None


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, N - N // _SETS, _CHUNK))
def test_a_damaged_file_ends_with_a_result_or_one_line(first, method, tmp_path):
    wrong = []
    for seed in range(first, min(first + _CHUNK, N - N // _SETS)):
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
