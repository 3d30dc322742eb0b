"""The equations in torch operations, including time stamps, against the package."""

import numpy as np
import pytest
import torch

from narx.errors import MethodNotApplicableError
from narx.export.recurrence import Recurrence
from narx.export.torchscript import ScriptedNarx
from narx.inference.stream import OrientationStream

# the package takes tanh, sine and cosine from rational approximations
ATOL_RAD = 1e-9


def tensor(angles):
    return None if angles is None else torch.from_numpy(angles)


def test_whole_recording_and_sample_by_sample_equal_the_package(checkpoint, rates, expected):
    narx = ScriptedNarx(checkpoint)
    for start, angles in expected.values():
        whole = narx(torch.from_numpy(rates), tensor(start)).numpy()
        np.testing.assert_allclose(whole, angles, atol=ATOL_RAD, rtol=0)
        assert np.nanmax(np.abs(whole)) > 0.1
        state = narx.start(tensor(start))
        for k, sample in enumerate(torch.from_numpy(rates)):
            one, state = narx.step(sample, state)
            np.testing.assert_array_equal(one, whole[k])


@pytest.mark.parametrize("checkpoint", ["default", "longer_delays"], indirect=True)
def test_sensors_with_time_stamps_equal_the_package(checkpoint, rates):
    """Each sensor has its own losses, jitter and pauses."""
    rng = np.random.default_rng(0)
    several = np.stack([rates, np.roll(rates, 40, axis=0), rates[::-1]])
    intervals = 0.04 * rng.uniform([[1.0], [0.2], [0.7]], [[1.0], [1.0], [2.2]], (3, len(rates)))
    starts = rng.normal(size=(3, 3))
    stream = OrientationStream(checkpoint.method(), 25.0, n_sensors=3, initial_angles_rad=starts)
    angles = stream.update_block(several, np.cumsum(intervals, axis=1)).angles_rad
    narx = ScriptedNarx(checkpoint)
    result = narx(torch.from_numpy(several), tensor(starts), torch.from_numpy(intervals))
    np.testing.assert_allclose(result, angles, atol=ATOL_RAD, rtol=0)
    assert np.isfinite(angles).mean() > 0.9


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_the_network_takes_over_after_enough_movement_as_in_the_package(checkpoint, rates):
    start_up = checkpoint.start_up
    rates = rates[np.isfinite(rates).all(axis=1)]
    start = start_up.begin(np.zeros(3))
    taken = len(start_up.run(rates, 1 / 25.0, start))
    assert start_up.duration_s < (taken - 25) / 25.0 < 5.0  # standing prolonged the start-up
    recurrence = Recurrence(checkpoint)
    state = recurrence.start(torch.zeros(3).double(), torch.ones(1).double())
    for sample in torch.from_numpy(rates[: taken + 1]):
        before, state = state, recurrence.advance(sample, state)
    # the start-up's part of the state equals the package's and is constant once the network runs
    counted = before[:14].clone()
    counted[10:12] /= 25.0  # samples in the package, seconds here
    np.testing.assert_allclose(counted, start, atol=1e-12, rtol=0)
    np.testing.assert_array_equal(state[3:17], before[3:17])
    posture, *_ = start_up.hand_over(start, 1 / 25.0)
    np.testing.assert_allclose(state[14:17], posture, atol=1e-12, rtol=0)
    assert np.abs(posture).min() > 1e-3
    # the washout's mean is zero until the network starts
    assert not before[17:20].any()
    assert state[17:20].all()


def test_a_missing_sample_changes_only_the_time(checkpoint):
    narx = ScriptedNarx(checkpoint)
    state = narx.start(torch.tensor([0.1, 0.2, 0.3]))
    for bad in (float("nan"), float("inf"), -3e38):
        angles, after = narx.step(torch.tensor([0.1, bad, 0.1], dtype=torch.float64), state)
        assert angles.isnan().all()
        # the time since the latest sample, how late that was, and that this one is missing
        assert torch.equal(after[:-4], state[:-4])
        assert after.isfinite().all()


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_no_interval_leaves_nan_in_the_state(checkpoint):
    narx, rates = ScriptedNarx(checkpoint), torch.ones(3, dtype=torch.float64)
    _, state = narx.step(rates, narx.start())
    for bad in (0.0, -1.0, float("nan"), float("inf"), 1e300):
        _, after = narx.step(rates, state, torch.tensor(bad, dtype=torch.float64))
        assert after.isfinite().all()


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_float_does_not_drift_from_the_ticks(checkpoint):
    shape = (300, 40, 1)
    interval_s = torch.from_numpy(np.random.default_rng(0).uniform(0.03, 0.05, shape)).float()
    late_s = []
    for dtype in (torch.float32, torch.float64):
        clocked = ScriptedNarx(checkpoint).to(dtype).clocked
        state = clocked.start(torch.zeros(40, 3, dtype=dtype), torch.zeros(40, 1, dtype=dtype))
        samples, size = torch.zeros(40, 3, dtype=dtype), clocked.recurrence.state_size
        for interval in interval_s.to(dtype):
            *_, clock = clocked.arrive(samples, interval, state)
            state = torch.cat([state[:, :size], clock], dim=1)
        late_s.append(clock[:, 5].double() + clock[:, 6].double())
    # the rounding errors of float would add up to some 1e-8
    torch.testing.assert_close(late_s[0], late_s[1], atol=1e-9, rtol=0.0)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_type_and_device_are_those_of_the_module(checkpoint):
    narx = ScriptedNarx(checkpoint).to(torch.float32)
    state = narx.start(batch=[2, 4])
    assert state.shape == (2, 4, narx.state_size)
    angles, state = narx.step(torch.zeros(2, 4, 3, dtype=torch.float64), state)
    assert angles.dtype == state.dtype == torch.float32
    assert ScriptedNarx(checkpoint).to("meta").start(batch=[5]).device.type == "meta"


def test_nothing_in_nothing_out(checkpoint):
    assert ScriptedNarx(checkpoint)(torch.empty(0, 3)).shape == (0, 3)


def test_own_scaling_is_refused(own_scaling):
    with pytest.raises(MethodNotApplicableError, match=r"axis_scaling is 'own'.*whole recording"):
        Recurrence(own_scaling)
