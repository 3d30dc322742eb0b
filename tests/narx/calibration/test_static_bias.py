"""The bias from a sensor at rest, or else from all standing, weighted by precision."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from narx.calibration.static_bias import quietest_window, resting_mean, static_bias
from narx.recordings.trial import ImuRecording, Trial

_RATE_HZ = 100.0
_BIAS = np.radians([1.0, -2.0, 0.5])


def _noise(n, scale, seed=0):
    return np.random.default_rng(seed).normal(scale=scale, size=(n, 3))


def _recording(gyroscope, rate_hz=_RATE_HZ):
    time = np.arange(len(gyroscope)) / rate_hz
    return ImuRecording("thigh", time, gyroscope, np.zeros_like(gyroscope))


def test_quietest_window_agrees_with_a_plain_search():
    rate = _BIAS + _noise(1500, 0.05)
    rate[200:400] += 0.5
    rate[700] = np.nan
    found = quietest_window(rate, _RATE_HZ, "x")
    clean = rate[np.isfinite(rate).all(axis=1)]
    windows = [clean[k : k + 500] for k in range(len(clean) - 499)]
    best = min(windows, key=lambda w: w.var(axis=0).sum())
    assert found.bias_rad_s == pytest.approx(best.mean(axis=0), abs=1e-12)
    assert found.gyroscope_scatter_rad_s == pytest.approx(np.sqrt(best.var(axis=0).sum()), rel=1e-9)


def test_a_short_part_is_used_whole_and_an_empty_one_not_at_all():
    rate = _BIAS + _noise(50, 0.01)
    assert quietest_window(rate, _RATE_HZ, "x").bias_rad_s == pytest.approx(rate.mean(axis=0))
    assert quietest_window(np.full((5, 3), np.nan), _RATE_HZ, "x") is None


def _trial(gyroscope, still_s=(), **calibration):
    recordings = {name: {"thigh": _recording(rate)} for name, rate in calibration.items()}
    imus = {"thigh": _recording(gyroscope)}
    return Trial("d", "s", "c", "t", _RATE_HZ, imus, calibration=recordings, still_s=tuple(still_s))


def test_a_sensor_on_a_table_is_preferred_and_used_whole():
    walk = _noise(3000, 1.0)
    still, stand = _BIAS + _noise(3000, 0.01), 2 * _BIAS + _noise(1000, 0.001)
    part = static_bias(_trial(walk, [(0.0, 9.9)], still=still, standing=stand), "thigh")
    assert part.where == "recording 'still'"
    assert part.bias_rad_s == pytest.approx(still.mean(axis=0), abs=1e-12)
    assert part.gyroscope_scatter_rad_s == pytest.approx(np.sqrt(still.var(axis=0).sum()), rel=1e-9)


def test_the_hand_that_takes_the_sensor_up_is_left_out():
    still = _BIAS + _noise(3000, 0.003)
    still[:150] += 0.3
    still[-100:, 1] -= 2.0
    still[800] = np.nan
    found = resting_mean(still, _RATE_HZ, "x")
    clean = np.vstack([still[260:800], still[801:2840]])
    assert found.bias_rad_s == pytest.approx(clean.mean(axis=0), abs=2e-5)
    assert resting_mean(np.full((5, 3), np.nan), _RATE_HZ, "x") is None
    # a recording without rest gives no bias; the next recording in order is used
    shaking = np.tile([[1.0, 0, 0], [-1.0, 0, 0]], (50, 1)).repeat(20, axis=0)
    part = static_bias(_trial(shaking, still=shaking, standing=_noise(900, 0.01) + _BIAS), "thigh")
    assert part.where == "recording 'standing'"


def _sway(seconds, seed):
    """Rate of a person whose angle wanders about zero with a bandwidth of 0.5 Hz."""
    rng = np.random.default_rng(seed)
    knots = np.arange(-5.0, seconds + 6.0)
    angle = make_interp_spline(knots, 0.005 * rng.standard_normal((len(knots), 3)), k=5)
    return _BIAS + angle.derivative()(np.arange(round(seconds * _RATE_HZ)) / _RATE_HZ)


def test_stands_are_averaged_by_how_well_they_tell():
    errors = {name: [] for name in ("all", "long", "short")}
    for seed in range(60):
        long, short = _sway(10.0, seed), _sway(4.0, seed + 1000)
        walk = np.vstack([short, _noise(1000, 1.0)])
        for name, trial in (
            ("all", _trial(walk, [(0.0, 3.99)], standing=long)),
            ("long", _trial(walk, standing=long)),
            ("short", _trial(walk, [(0.0, 3.99)])),
        ):
            errors[name].append(static_bias(trial, "thigh").bias_rad_s - _BIAS)
    rms = {name: np.sqrt(np.mean(np.square(error))) for name, error in errors.items()}
    # the error of the mean rate is the angle between the ends divided by the duration
    assert rms["long"] / rms["short"] == pytest.approx(4.0 / 10.0, rel=0.25)
    assert rms["all"] < 1.02 * rms["long"]
    assert rms["all"] < 0.5 * rms["short"]


def test_a_restless_stand_counts_less_and_none_is_none():
    walk = np.vstack([3 * _BIAS + _noise(1000, 0.2), _noise(1000, 1.0)])
    quiet = _BIAS + _noise(1000, 0.001)
    part = static_bias(_trial(walk, [(0.0, 9.99)], standing=quiet), "thigh")
    assert part.bias_rad_s == pytest.approx(_BIAS, abs=2e-4)
    assert part.where == "recording 'standing' and still part 0.0-10.0 s"
    assert static_bias(_trial(walk), "thigh") is None


@pytest.mark.parametrize("rate_hz", [50.0, 100.0])
def test_weights_of_standing_parts_by_hand(rate_hz):
    """The inverse variance of the mean rate: (duration / SD of the angle between the ends)^2."""
    alternating = np.where(np.arange(2000) % 2, 1.0, -1.0)[:, None] * [1.0, 0.0, 0.0]
    standing = [0.02, 0.0, 0.0] + 0.01 * alternating[: round(8 * rate_hz)]
    walk = np.vstack([[0.05, 0.0, 0.0] + 0.03 * alternating[:400], _noise(600, 1.0)])
    trial = _trial(walk, [(0.0, 3.995)])
    trial = replace(trial, calibration={"standing": {"thigh": _recording(standing, rate_hz)}})
    part = static_bias(trial, "thigh")
    weights = np.array([(8.0 / 0.01) ** 2, (4.0 / 0.03) ** 2])
    weights /= weights.sum()
    assert part.bias_rad_s == pytest.approx([weights @ [0.02, 0.05], 0.0, 0.0])
    assert part.gyroscope_scatter_rad_s == pytest.approx(np.sqrt(weights @ np.square([0.01, 0.03])))


@pytest.mark.parametrize(("rate_deg_s", "left_out"), [(1.8, False), (2.3, True)])
def test_handling_is_faster_than_2_deg_s_and_taken_out_with_half_a_second(rate_deg_s, left_out):
    still = np.zeros((3000, 3))
    still[1000:1200, 2] = np.radians(rate_deg_s)
    still[955:1245, 0] = 0.01  # 0.45 s to either side
    found = resting_mean(still, _RATE_HZ, "x").bias_rad_s
    if left_out:
        assert found == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    else:
        assert found[0] == pytest.approx(0.01 * 290 / 3000)


def test_noise_above_2_deg_s_is_not_handling():
    """Averaged over a tenth of a second, ten samples, it is a third as large."""
    still = _BIAS + _noise(3000, np.radians(1.0))
    found = resting_mean(still, _RATE_HZ, "x").bias_rad_s
    assert found == pytest.approx(still.mean(axis=0), abs=1e-12)
