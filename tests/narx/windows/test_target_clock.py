"""The lag between target and gyroscope is estimated to a fraction of a sample and removed."""

import numpy as np
import pytest

from narx.errors import UserError
from narx.kinematics.segment_angles import coupled_rates
from narx.method import SegmentSignals
from narx.windows import TrainingSequence
from narx.windows.target_clock import on_gyroscope_clock, target_lag_s

RATE_HZ = 100.0


def angles_at(time_s):
    """Sagittal, frontal and transverse angle of a walk, and their rates."""
    angles, rates = np.zeros((len(time_s), 3)), np.zeros((len(time_s), 3))
    for axis, size in enumerate((0.4, 0.1, 0.15)):
        for k in (1, 2, 3):
            omega, phase = 2 * np.pi * 0.9 * k, axis + 0.7 * k
            angles[:, axis] += size / k**2 * np.sin(omega * time_s + phase)
            rates[:, axis] += size / k**2 * omega * np.cos(omega * time_s + phase)
    return angles, rates


def gyroscope(angles, rates):
    """Rates about the sensor's axes: the inverse of `coupled_rates`, sample by sample."""
    unit = np.stack(
        [coupled_rates(np.tile(e, (len(angles), 1)), angles) for e in np.eye(3)], axis=-1
    )
    return np.linalg.solve(unit, rates[..., None])[..., 0]


def walk(lag_s, seconds=30.0, name="walk", bias_rad_s=0.0, noise_deg=0.0):
    time_s = np.arange(0.0, seconds, 1 / RATE_HZ)
    gyro = gyroscope(*angles_at(time_s)) + bias_rad_s
    target, _ = angles_at(time_s - lag_s)
    target += np.radians(noise_deg) * np.random.default_rng(0).standard_normal(target.shape)
    return TrainingSequence(
        name, SegmentSignals("thigh", RATE_HZ, gyro, np.zeros_like(gyro)), target
    )


@pytest.mark.parametrize("lag_s", [0.0, 0.0023, -0.0071, 0.03])
def test_a_lag_is_found_below_a_sample_and_removed(lag_s):
    late = walk(lag_s)
    assert target_lag_s([late]) == pytest.approx(lag_s, abs=5e-5)
    (aligned,) = on_gyroscope_clock([late])
    inside = slice(10, -10)
    truth, _ = angles_at(np.arange(0.0, 30.0, 1 / RATE_HZ))
    np.testing.assert_allclose(aligned.target_rad[inside], truth[inside], atol=1e-4)
    assert aligned.signals is late.signals


def test_bias_noise_and_gaps_hardly_matter():
    late = walk(0.004, bias_rad_s=0.02, noise_deg=0.05)
    late.target_rad[500:900] = np.nan
    late.target_rad[:, 2] = np.nan  # a heading without reference
    assert target_lag_s([late]) == pytest.approx(0.004, abs=3e-4)
    (aligned,) = on_gyroscope_clock([late])
    missing = np.isnan(aligned.target_rad)
    assert missing[:, 2].all()
    assert missing[501:899, :2].all()
    # nothing is extrapolated, and not more than a sample is lost at an edge
    assert missing[:, 0].sum() <= 400 + 2


def test_each_trial_has_its_own_lag_and_its_pieces_share_it():
    one, other = walk(0.006, name="one"), walk(-0.003, name="other")
    half = [
        TrainingSequence("one", one.signals.select(part), one.target_rad[part])
        for part in (slice(0, 1500), slice(1500, 3000))
    ]
    aligned = on_gyroscope_clock([half[0], other, half[1]])
    assert [sequence.name for sequence in aligned] == ["one", "other", "one"]
    for sequence in aligned:
        assert target_lag_s([sequence]) == pytest.approx(0.0, abs=1e-4)


def test_targets_that_do_not_follow_the_gyroscope_are_unchanged():
    still = walk(0.0)
    noise = np.random.default_rng(0).standard_normal(still.target_rad.shape)
    for target in (np.zeros_like(noise), noise, np.full_like(noise, np.nan)):
        strange = TrainingSequence("walk", still.signals, target)
        assert target_lag_s([strange]) is None
        assert on_gyroscope_clock([strange])[0] is strange
    short = TrainingSequence("walk", still.signals.select(slice(0, 50)), still.target_rad[:50])
    assert target_lag_s([short]) is None
    assert on_gyroscope_clock([]) == []


@pytest.mark.parametrize(("lag_s", "how"), [(0.08, "late"), (-0.08, "early")])
def test_clocks_that_were_never_aligned_are_refused(lag_s, how):
    with pytest.raises(UserError, match=rf"walk is at least 50 ms {how}; .*align_clock=false"):
        target_lag_s([walk(lag_s)])


@pytest.mark.parametrize(("explained", "found"), [(0.4, False), (0.6, True)])
def test_half_of_the_variance_has_to_be_explained(explained, found):
    """Noise is added until the gyroscope explains the given share of the target's changes."""
    late = walk(0.004)
    noise = np.random.default_rng(1).standard_normal(late.target_rad.shape)

    def power(angles):  # of the changes over a quarter of a second, sagittal and frontal
        return np.sum((angles[25:, :2] - angles[:-25, :2]) ** 2)

    noise *= np.sqrt(power(late.target_rad) / power(noise) * (1.0 - explained) / explained)
    lag_s = target_lag_s([TrainingSequence("walk", late.signals, late.target_rad + noise)])
    assert (lag_s is not None) == found
    assert lag_s is None or lag_s == pytest.approx(0.004, abs=0.005)


@pytest.mark.parametrize("ends", [slice(None, 3), slice(-3, None)])
def test_what_happens_at_the_ends_of_a_recording_does_not_count(ends):
    """The spline of the gyroscope ends there; continued, a knock shifts the lag by 7 to 10 ms."""
    knocked = walk(0.004, seconds=5.0)
    knocked.signals.axis_rates_rad_s[ends] += 30.0
    assert target_lag_s([knocked]) == pytest.approx(0.004, abs=1e-4)


def test_a_short_gap_of_the_target_stays_a_gap():
    late = walk(0.004)
    late.target_rad[500:503] = np.nan
    (aligned,) = on_gyroscope_clock([late])
    missing = np.flatnonzero(np.isnan(aligned.target_rad[10:-10, 0])) + 10
    np.testing.assert_array_equal(missing, np.arange(499, 503))
