"""Every form of a network with its tracker beside the package's compiled one."""

import json
from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from narx.export import read_identity, write
from narx.export.graph import program
from narx.export.tracked import ExportedTracked
from narx.inference.checkpoint import Checkpoint
from narx.inference.tracker import PostureTracker
from narx.inference.tracking import Tracking
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
            walks * 0.3 * np.sin(phase) + 0.6 * slipped,
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


def expected(checkpoint, inputs, start):
    tracking = Tracking(checkpoint.tracker, checkpoint.model, start)
    tracked = tracking.follow(inputs[:, :3].copy(), inputs[:, 3:].copy())
    return tracked.angles_rad, tracking.packed, tracked


def of(checkpoint, inputs):
    return np.ascontiguousarray(inputs if checkpoint.tracker.aided else inputs[:, :3])


def run(step, state, inputs):
    angles = []
    with torch.no_grad():
        for sample in torch.from_numpy(inputs):
            one, state = step(sample, state)
            angles.append(one.numpy())
    return np.array(angles), state.numpy()


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_step_equals_the_package_state_and_all(checkpoint, inputs, start):
    narx = ExportedTracked(checkpoint)
    angles, state, tracked = expected(checkpoint, inputs, start)
    # the recording goes through what there is: both ways to carry the angle, a gap, a new posture
    assert tracked.by_network.any()
    assert not tracked.by_network[100:].all()
    begun = narx.start(None if start is None else torch.from_numpy(start))
    assert begun.shape == (narx.state_size,)
    for step in (narx.step, narx.one_step):
        found, after = run(step, begun, of(checkpoint, inputs))
        np.testing.assert_allclose(found, angles, atol=1e-10, rtol=0)
        np.testing.assert_allclose(after, state, atol=1e-8, rtol=0)
    whole = narx(
        torch.from_numpy(of(checkpoint, inputs[:100])), None if start is None else begun[:3]
    )
    np.testing.assert_array_equal(whole.numpy(), found[:100])


@pytest.mark.parametrize(
    ("precision", "dtype", "atol_rad"), [("double", np.float64, 1e-10), ("float", np.float32, 0.01)]
)
def test_c_equals_the_package(checkpoint, inputs, in_c, precision, dtype, atol_rad):
    step = in_c(checkpoint, precision, dtype)
    for start in STARTS.values():
        angles, _, _ = expected(checkpoint, inputs, start)
        found = step(of(checkpoint, inputs), start)
        np.testing.assert_allclose(found, angles, atol=atol_rad, rtol=0)


@pytest.mark.parametrize("checkpoint", ["gyroscope", "aided"], indirect=True)
def test_torchscript_and_torch_export_hold_the_same_step(checkpoint, inputs, tmp_path):
    narx, short = ExportedTracked(checkpoint), of(checkpoint, inputs[50:200])
    angles, _ = run(narx.step, narx.start(), short)
    write(checkpoint, tmp_path / "narx.pt")
    script = torch.jit.load(tmp_path / "narx.pt")
    np.testing.assert_allclose(run(script.step, script.start(), short)[0], angles, atol=1e-12)
    step = program(checkpoint, torch.float64).module()
    np.testing.assert_allclose(run(step, narx.start(), short)[0], angles, atol=1e-12)


@pytest.mark.parametrize("checkpoint", ["gyroscope", "aided"], indirect=True)
def test_onnx_holds_the_same_step(checkpoint, inputs, tmp_path):
    runtime = pytest.importorskip("onnxruntime")
    pytest.importorskip("onnxscript")
    write(checkpoint, tmp_path / "narx.onnx", "onnx")
    session = runtime.InferenceSession(tmp_path / "narx.onnx")
    told = json.loads(session.get_modelmeta().custom_metadata_map["narx"])
    assert told == read_identity(tmp_path / "narx.onnx")
    state, short = np.array(told["known_start_state"]), of(checkpoint, inputs[50:150])
    angles, _ = run(ExportedTracked(checkpoint).step, torch.from_numpy(state), short)
    found = []
    for sample in short:
        one, state = session.run(None, {"axis_rates": sample, "state": state})
        found.append(one)
    np.testing.assert_allclose(found, angles, atol=1e-10, rtol=0)


def test_a_network_that_cannot_be_tracked_is_refused():
    good = CHECKPOINTS["gyroscope"]
    axis_by_axis = Narx(RATE_HZ, good.model.normalisation, coupled=False)
    with pytest.raises(Exception, match=r"model\.coupled=true"):
        ExportedTracked(replace(good, model=axis_by_axis))
