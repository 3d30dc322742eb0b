import numpy as np
import pytest
import torch

from narx.errors import MethodNotApplicableError
from narx.export.recurrence import ExportedNarx, StepGraph, description
from narx.inference.stream import OrientationStream


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


def test_whole_recording_and_sample_by_sample_equal_the_package(checkpoint, rates, expected):
    narx = ExportedNarx(checkpoint)
    for start, angles in expected.values():
        whole = narx(torch.from_numpy(rates), tensor(start)).numpy()
        np.testing.assert_allclose(whole, angles, atol=ATOL_RAD, rtol=0)
        assert np.nanmax(np.abs(whole)) > 0.1
        for step in (narx.step, StepGraph(narx)):
            pieces = run(step, narx.start(tensor(start)), rates)
            np.testing.assert_allclose(pieces, whole, atol=1e-13, rtol=0)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_the_network_takes_over_after_enough_movement_as_in_the_package(checkpoint, rates):
    start_up = checkpoint.start_up
    rates = rates[np.isfinite(rates).all(axis=1)]
    start = start_up.begin(np.zeros(3))
    taken = len(start_up.run(rates, 1 / 25.0, start))
    assert start_up.duration_s < (taken - 25) / 25.0 < 5.0  # there was standing in between
    narx = ExportedNarx(checkpoint)
    state = narx.start(torch.zeros(3))
    for sample in torch.from_numpy(rates[: taken + 1]):
        before, state = state, narx.step(sample, state)[1]
    # the start-up's part of the state is the package's, and stays once the network works
    np.testing.assert_allclose(before[:14], start, atol=1e-12, rtol=0)
    np.testing.assert_array_equal(state[:17], before[:17])
    posture, *_ = start_up.hand_over(start, 1 / 25.0)
    np.testing.assert_allclose(state[14:17], posture, atol=1e-12, rtol=0)
    assert np.abs(posture).min() > 1e-3
    # nothing is taken off until then, and from then on more and more
    assert not before[17:20].any()
    assert state[17:20].all()


def test_sample_by_sample_equals_the_package_stream(checkpoint, rates):
    narx = ExportedNarx(checkpoint)
    expected = OrientationStream(checkpoint.method(), 25.0).update_block(rates).angles_rad
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
