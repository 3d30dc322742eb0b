"""Every exported form of a tracked network against the package's compiled one."""

import ctypes
import io
import shutil
from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from narx.export import c, read_identity, torchscript, write
from narx.export.clocked import ClockedRecurrence
from narx.export.torchscript import ScriptedNarx
from narx.export.tracker_numbers import between_samples
from narx.inference.checkpoint import Checkpoint
from narx.inference.stream import OrientationStream, Quality
from narx.inference.tracker import PostureTracker
from narx.kinematics.segment_angles import axis_rates, orientation_from_angles
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.structure import NarxStructure
from narx.training.initial_weights import leaky_integrator_weights

RATE_HZ = 25.0
STARTS = {"unknown": None, "known": np.array([0.1, -0.05, 0.2])}


def make(structure, aided):
    model = Narx(RATE_HZ, Normalisation(3.0, 0.5, 0.0, 0.0), structure)
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(leaky_integrator_weights(model, 0.1)))
    return Checkpoint(model, tracker=PostureTracker(aided=aided, std_scale=(1.1, 0.9, 1.2)))


CHECKPOINTS = {
    "gyroscope": make(NarxStructure(), False),
    "aided": make(NarxStructure(), True),
    "shortest_delays": make(NarxStructure(2, 1, 1, 1), False),
    "longer_delays": make(NarxStructure(2, 1, 4, 3), True),
}


@pytest.fixture(params=CHECKPOINTS)
def checkpoint(request):
    return CHECKPOINTS[request.param]


@pytest.fixture(scope="module")
def inputs():
    """Rests, walks with a turn, loses samples, slips in the pocket and walks on."""
    time = np.arange(0.0, 24.0, 1.0 / RATE_HZ)
    walks = (time > 3.0).astype(float)
    slipped = np.clip((time - 16.0) / 0.5, 0.0, 1.0)
    phase = 2.0 * np.pi * 0.9 * time
    angles = np.column_stack(
        [
            # faster forward than backward, as a leg
            walks * (0.3 * np.sin(phase) + 0.1 * np.sin(2.0 * phase)) + 0.6 * slipped,
            walks * 0.08 * np.sin(phase + 1.0),
            0.6 * np.clip(time - 8.0, 0.0, 5.0) + walks * 0.05 * np.sin(phase),
        ]
    )
    turned = Rotation.from_quat(orientation_from_angles(angles), scalar_first=True)
    rates = (turned[:-1].inv() * turned[1:]).as_rotvec() * RATE_HZ
    rates = np.vstack([rates, rates[-1:]]) + np.radians([0.4, -0.3, 0.2])
    force = turned.inv().apply(np.tile([0.0, 0.0, 9.81], (len(time), 1)))
    force += np.random.default_rng(0).normal(scale=0.5, size=force.shape)
    both = np.hstack([axis_rates(rates), force])
    both[350:356] = np.nan
    both[450, 1] = np.inf
    return both


def of(checkpoint, inputs):
    return np.ascontiguousarray(inputs if checkpoint.tracker.aided else inputs[:, :3])


def expected(checkpoint, inputs, interval_s, start):
    stream = OrientationStream(checkpoint.method(), RATE_HZ, initial_angles_rad=start)
    return stream.update_block(of(checkpoint, inputs), np.cumsum(interval_s))


@pytest.fixture(scope="module", params=["regular", "jitter"])
def interval_s(request, inputs):
    share = 0.3 if request.param == "jitter" else 0.0
    spread = share * np.random.default_rng(1).uniform(-1.0, 1.0, len(inputs))
    return (1.0 + spread) / RATE_HZ


def test_torch_form_equals_the_package(checkpoint, inputs, interval_s):
    narx = ClockedRecurrence(checkpoint)
    both = [expected(checkpoint, inputs, interval_s, start) for start in STARTS.values()]
    # the recording contains samples of every quality
    quality = both[0].quality
    assert set(Quality) == set(quality)
    state = narx.start(
        torch.tensor(np.stack([np.zeros(3), STARTS["known"]])), torch.tensor([[0.0], [1.0]])
    )
    scripted = ScriptedNarx(checkpoint)
    angles, std, qualities = [], [], []
    with torch.no_grad():
        for sample, interval in zip(of(checkpoint, inputs), interval_s, strict=True):
            one, state = scripted.step(
                torch.from_numpy(sample).expand(2, -1), state, torch.tensor([interval, interval])
            )
            angles.append(one.numpy())
            std.append(scripted.standard_deviation(state).numpy())
            qualities.append(scripted.quality(state).numpy())
    for at, estimate in enumerate(both):
        found = np.array(angles)[:, at]
        np.testing.assert_allclose(found, estimate.angles_rad, atol=1e-9, rtol=0)
        np.testing.assert_allclose(np.array(std)[:, at], estimate.std_rad, rtol=1e-6)
        np.testing.assert_array_equal(np.array(qualities)[:, at], estimate.quality)


@pytest.mark.parametrize(
    ("precision", "dtype", "atol_rad"), [("double", np.float64, 1e-9), ("float", np.float32, 1e-4)]
)
def test_c_equals_the_package(checkpoint, inputs, in_c, precision, dtype, atol_rad):
    step = in_c(checkpoint, precision, dtype)
    interval_s = np.full(len(inputs), 1.0 / RATE_HZ)
    for start in STARTS.values():
        angles = expected(checkpoint, inputs.astype(dtype), interval_s, start).angles_rad
        found = step(of(checkpoint, inputs), start)
        np.testing.assert_allclose(found, angles, atol=atol_rad, rtol=0)


def test_c_gives_standard_deviations_and_quality(inputs, in_c, tmp_path):
    checkpoint = CHECKPOINTS["gyroscope"]
    in_c(checkpoint, "double", np.float64)
    library = ctypes.CDLL(str(tmp_path / "narx.so"))
    state, deviations, quality = ctypes.create_string_buffer(8192), [], []
    angles, std = np.empty(3), np.empty(3)
    library.narx_start(state, None)
    for sample in of(checkpoint, inputs):
        library.narx_step(state, *(ctypes.c_void_p(one.ctypes.data) for one in (sample, angles)))
        library.narx_standard_deviation(state, ctypes.c_void_p(std.ctypes.data))
        deviations.append(std.copy())
        quality.append(library.narx_quality(state))
    wanted = expected(checkpoint, inputs, np.full(len(inputs), 1.0 / RATE_HZ), None)
    np.testing.assert_array_equal(quality, wanted.quality)
    there = wanted.quality != Quality.MISSING
    np.testing.assert_allclose(np.array(deviations)[there], wanted.std_rad[there], rtol=1e-6)


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("at", [0, 300])
def test_no_input_leaves_nan(inputs, precision, at):
    checkpoint = CHECKPOINTS["aided"]
    dtype = {"double": np.float64, "float": np.float32}[precision]
    signal, rng = inputs[None].astype(dtype), np.random.default_rng(2)
    for value in (3e38, -3e38, 1e30, np.inf, -np.inf, np.nan, 1e-40):
        signal[0, at + rng.integers(40), rng.integers(6)] = value
    interval_s = np.full(signal.shape[:2], 1.0 / RATE_HZ, dtype)
    script = torch.jit.load(
        io.BytesIO(torchscript.build(checkpoint, getattr(torch, np.dtype(dtype).name)))
    )
    state, later = script.start(), torch.from_numpy(signal[0, at : at + 60])
    with torch.no_grad():
        for sample in later:
            _, state = script.step(sample, state)
    assert torch.isfinite(state).all()
    assert (script.standard_deviation(state) > 0.0).all()
    if shutil.which("gcc"):
        run = c.loaded(c.stamped(c.build(checkpoint, precision), "narx", ""))
        found = run(signal, interval_s, None)
        assert np.isfinite(found[0, -100:]).all()


@pytest.mark.parametrize(
    ("time_s", "rate_hz"), [(0.5, 100.0), (2.5, 100.0), (1.5, 25.0), (0.3, 7.0)]
)
def test_times_are_compared_between_two_samples(time_s, rate_hz):
    sums = np.cumsum(np.full(1000, 1.0 / rate_hz))
    counts = np.arange(1, 1001) / np.float32(rate_hz)
    np.testing.assert_array_equal(
        counts > between_samples(time_s, 1.0 / rate_hz, above=True), sums > time_s
    )
    np.testing.assert_array_equal(
        counts < between_samples(time_s, 1.0 / rate_hz, above=False), sums < time_s
    )


@pytest.mark.parametrize(
    ("name", "precision"),
    [
        ("torchscript", "double"),
        ("torchscript", "float"),
        # the graphs differ between precisions in their numbers only: those without a tracker are
        # written in the other one (test_graph.py)
        ("torch_export", "double"),
        ("onnx", "float"),
    ],
)
@pytest.mark.slow
def test_every_format(name, precision, tmp_path):
    if name == "onnx":
        for library in ("onnx", "onnxscript", "onnxruntime"):
            pytest.importorskip(library)
    suffix = {"torchscript": ".pt", "torch_export": ".pt2", "onnx": ".onnx"}[name]
    path = tmp_path / f"narx{suffix}"
    about = write(CHECKPOINTS["aided"], path, name, precision)
    assert about == read_identity(path)
    tolerance_rad = {"double": 1e-9, "float": 1e-4}[precision]
    assert 0.0 < about["verification"]["largest_difference_rad"] < tolerance_rad


def test_a_network_that_cannot_be_tracked_is_refused():
    good = CHECKPOINTS["gyroscope"]
    axis_by_axis = Narx(RATE_HZ, good.model.normalisation, coupled=False)
    with pytest.raises(Exception, match=r"model\.coupled=true"):
        ClockedRecurrence(replace(good, model=axis_by_axis))
