"""The bias comes from the quietest part, whatever else the recording holds."""

import numpy as np
import pytest

from narx.recording import ImuRecording, Trial
from narx.static_bias import first_rest_s, quietest_window, static_bias

_RATE_HZ = 100.0
_BIAS = np.radians([1.0, -2.0, 0.5])


def _noise(n, scale, seed=0):
    return np.random.default_rng(seed).normal(scale=scale, size=(n, 3))


def _recording(gyroscope):
    time = np.arange(len(gyroscope)) / _RATE_HZ
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
    assert found.unrest_rad_s == pytest.approx(np.sqrt(best.var(axis=0).sum()), rel=1e-9)


def test_a_short_part_is_used_whole_and_an_empty_one_not_at_all():
    rate = _BIAS + _noise(50, 0.01)
    assert quietest_window(rate, _RATE_HZ, "x").bias_rad_s == pytest.approx(rate.mean(axis=0))
    assert quietest_window(np.full((5, 3), np.nan), _RATE_HZ, "x") is None


def test_the_quietest_of_all_parts_wins():
    walk = _recording(_noise(3000, 1.0))
    walk.gyroscope_rad_s[:1000] = 2 * _BIAS + _noise(1000, 0.02)
    still = _recording(_BIAS + _noise(1000, 0.001))
    trial = Trial(
        "d",
        "s",
        "c",
        "t",
        _RATE_HZ,
        {"thigh": walk},
        calibration={"still": {"thigh": still}},
        still_s=((0.0, 9.9),),
    )
    part = static_bias(trial, "thigh")
    assert part.where == "recording 'still'"
    assert part.bias_rad_s == pytest.approx(_BIAS, abs=1e-3)
    alone = Trial("d", "s", "c", "t", _RATE_HZ, {"thigh": walk}, still_s=((0.0, 9.9),))
    assert static_bias(alone, "thigh").bias_rad_s == pytest.approx(2 * _BIAS, abs=5e-3)
    assert static_bias(Trial("d", "s", "c", "t", _RATE_HZ, {"thigh": walk}), "thigh") is None


def test_rest_ends_when_the_first_sensor_moves():
    quiet, moving = _BIAS + _noise(1000, 0.01), _BIAS + _noise(1000, 0.01, 1)
    moving[300:, 1] += 1.0
    assert first_rest_s([quiet, moving], _RATE_HZ) == pytest.approx(2.9, abs=0.1)
    assert first_rest_s([quiet], _RATE_HZ) == pytest.approx(9.9, abs=0.1)
    shaking = np.tile([[1.0, 0, 0], [-1.0, 0, 0]], (500, 1)).repeat(20, axis=0)
    assert first_rest_s([shaking], _RATE_HZ) < 0.1
