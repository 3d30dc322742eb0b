import numpy as np
import pytest
import torch

from narx.errors import MethodNotApplicableError
from narx.export.recurrence import ExportedNarx, StepGraph, description


def tensor(angles):
    return None if angles is None else torch.from_numpy(angles)


def run(step, state, rates):
    angles = []
    for sample in torch.from_numpy(rates):
        one, state = step(sample, state)
        angles.append(one)
    return torch.stack(angles).numpy()


# the package's loop takes tanh, sine and cosine from rational approximations
ATOL_RAD = 1e-8


def test_whole_recording_equals_the_package(checkpoint, rates, initial_angles, expected):
    angles = ExportedNarx(checkpoint)(torch.from_numpy(rates), tensor(initial_angles))
    np.testing.assert_allclose(angles.numpy(), expected, atol=ATOL_RAD, rtol=0)
    assert np.nanmax(np.abs(expected)) > 0.1


def test_sample_by_sample_equals_whole_recording(checkpoint, rates, initial_angles):
    narx = ExportedNarx(checkpoint)
    whole = narx(torch.from_numpy(rates), tensor(initial_angles)).numpy()
    for step in (narx.step, StepGraph(narx)):
        pieces = run(step, narx.start(tensor(initial_angles)), rates)
        np.testing.assert_allclose(pieces, whole, atol=1e-13, rtol=0)


def test_sample_by_sample_equals_the_package_stream(checkpoint, rates):
    narx = ExportedNarx(checkpoint)
    stream = checkpoint.method().stream(narx.sampling_rate_hz)
    expected = [stream(sample, np.zeros(3)) for sample in rates]
    np.testing.assert_allclose(run(narx.step, narx.start(), rates), expected, atol=1e-12, rtol=0)


def test_a_missing_sample_leaves_the_state_alone(checkpoint):
    narx = ExportedNarx(checkpoint)
    state = narx.start(torch.tensor([0.1, 0.2, 0.3]))
    for bad in (float("nan"), float("inf")):
        for step in (narx.step, StepGraph(narx)):
            angles, after = step(torch.tensor([0.1, bad, 0.1], dtype=torch.float64), state)
            assert angles.isnan().all()
            assert torch.equal(after, state)


def test_state_is_as_long_as_said(checkpoint):
    narx = ExportedNarx(checkpoint)
    assert narx.start().shape == (narx.state_size,)
    assert description(narx)["start_state"] == narx.start().tolist()


def test_nothing_in_nothing_out(checkpoint):
    assert ExportedNarx(checkpoint)(torch.empty(0, 3)).shape == (0, 3)


def test_own_scaling_is_refused(own_scaling):
    with pytest.raises(MethodNotApplicableError, match=r"axis_scaling is 'own'.*whole recording"):
        ExportedNarx(own_scaling)
