"""Networks of several shapes, a recording with gaps, and the package's angles for it."""

import ctypes
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
import torch

from narx.export import write
from narx.inference.checkpoint import Checkpoint
from narx.inference.start_up import StartUp
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.structure import NarxStructure

RATE_HZ = 25.0


def make_checkpoint(
    *,
    odd=True,
    coupled=True,
    hidden=3,
    input_lags=2,
    output_lags=2,
    duration_s=3.0,
    washout_s=2.0,
):
    offsets = (0.0, 0.0) if odd or coupled else (0.1, -0.05)
    model = Narx(
        RATE_HZ,
        Normalisation(3.0, 0.5, *offsets),
        NarxStructure(hidden, 1, input_lags, output_lags),
        odd,
        coupled,
    )
    generator = torch.Generator().manual_seed(hidden + 10 * output_lags)
    weights = 0.4 * torch.randn(model.weights.shape, generator=generator, dtype=torch.float64)
    with torch.no_grad():
        model.weights.copy_(weights * model.trainable)
    start_up = StartUp(duration_s=duration_s, averaging_s=1.0)
    return Checkpoint(model, start_up, washout_s=washout_s)


CHECKPOINTS = {
    "default": make_checkpoint(),
    "biases": make_checkpoint(odd=False),
    "axis_by_axis": make_checkpoint(coupled=False),
    "offsets": make_checkpoint(odd=False, coupled=False),
    "no_washout": make_checkpoint(washout_s=None),
    "no_start_up": make_checkpoint(odd=False, duration_s=0.0),
    "offsets_no_start_up": make_checkpoint(odd=False, coupled=False, duration_s=0.0),
    "shortest_delays": make_checkpoint(odd=False, hidden=5, input_lags=1, output_lags=1),
    "longer_delays": make_checkpoint(hidden=2, input_lags=4, output_lags=3),
    "never_over": make_checkpoint(duration_s=60.0),
}
STARTS = {"unknown": None, "known": np.array([0.3, -0.1, 0.2])}


@pytest.fixture(params=CHECKPOINTS)
def checkpoint(request):
    return CHECKPOINTS[request.param]


@pytest.fixture
def own_scaling():
    return replace(CHECKPOINTS["default"], axis_scaling="own")


@pytest.fixture(scope="session")
def rates():
    """Stands, moves, stands, then tumbles through 90 degrees; with missing samples."""
    size_rad_s = np.repeat([0.02, 1.0, 0.02, 3.0], [25, 13, 62, 65])
    rates = size_rad_s[:, None] * np.random.default_rng(0).normal(size=(165, 3))
    rates[[20, 21, 110], :] = np.nan
    rates[150, 1] = np.nan
    return rates


@pytest.fixture
def expected(checkpoint, rates):
    """Each kind of start with the package's angles over the whole recording."""

    def angles(start):
        signals = SegmentSignals("thigh", RATE_HZ, rates, np.zeros_like(rates), start)
        return checkpoint.method().estimate(signals)

    return {name: (start, angles(start)) for name, start in STARTS.items()}


C_FLAGS = (
    "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror",
)  # fmt: skip


@pytest.fixture
def in_c(tmp_path):
    """Compile a checkpoint: (checkpoint, precision, dtype) to (inputs, start) to angles."""
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")

    def compiled(checkpoint, precision, dtype):
        write(checkpoint, tmp_path / "narx.c", "c", precision, verify=precision == "double")
        library = tmp_path / "narx.so"
        command = ["gcc", *C_FLAGS, "-O2", "-shared", "-fPIC", "narx.c", "-o", library, "-lm"]
        subprocess.run(command, cwd=tmp_path, check=True)
        compiled = ctypes.CDLL(str(library))
        pointer = np.ctypeslib.ndpointer(dtype, flags="C_CONTIGUOUS")
        compiled.narx_step.argtypes = [ctypes.c_void_p, pointer, pointer]
        compiled.narx_start.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
        compiled.narx_step.restype = compiled.narx_start.restype = None

        def run(inputs, initial_angles):
            state = ctypes.create_string_buffer(8192)
            start = None if initial_angles is None else initial_angles.astype(dtype)
            compiled.narx_start(state, None if start is None else start.ctypes.data)
            angles = np.empty((len(inputs), 3), dtype)
            for sample, row in zip(inputs.astype(dtype), angles, strict=True):
                compiled.narx_step(state, sample, row)
            return angles

        return run

    return compiled
