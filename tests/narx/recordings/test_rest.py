import numpy as np
import pytest

from narx.recordings.rest import first_rest_s

_RATE_HZ = 100.0
_BIAS = np.radians([1.0, -2.0, 0.5])


def _noise(n, scale, seed=0):
    return np.random.default_rng(seed).normal(scale=scale, size=(n, 3))


def test_rest_ends_when_the_first_sensor_moves():
    quiet, moving = _BIAS + _noise(1000, 0.01), _BIAS + _noise(1000, 0.01, 1)
    moving[300:, 1] += 1.0
    assert first_rest_s([quiet, moving], _RATE_HZ) == pytest.approx(2.9, abs=0.1)
    assert first_rest_s([quiet], _RATE_HZ) == pytest.approx(9.9, abs=0.1)
    shaking = np.tile([[1.0, 0, 0], [-1.0, 0, 0]], (500, 1)).repeat(20, axis=0)
    assert first_rest_s([shaking], _RATE_HZ) < 0.1


@pytest.mark.parametrize(("rate_deg_s", "ends"), [(8.0, False), (12.0, True)])
def test_a_movement_of_10_deg_s_beyond_the_bias_ends_the_rest(rate_deg_s, ends):
    """The bias is that of an old sensor, 15 deg/s, measured over the first half second."""
    rate = np.radians(15.0) + _noise(1000, 1e-3)
    rate[300:400, 1] += np.radians(rate_deg_s)
    # a tenth of a second before the movement
    expected = 2.9 if ends else 9.9
    assert first_rest_s([rate], _RATE_HZ) == pytest.approx(expected, abs=0.06)


def test_the_bias_is_that_of_the_first_half_second():
    """A sensor that turns steadily from the first second on rests until shortly before it."""
    rate = _BIAS + _noise(1000, 1e-3)
    rate[100:, 2] += 1.0
    assert first_rest_s([rate], _RATE_HZ) == pytest.approx(0.85, abs=0.06)
