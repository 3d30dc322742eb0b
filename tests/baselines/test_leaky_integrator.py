"""The state-dependent leak against the explicit recursion."""

import numpy as np
import pytest

from narx.baselines.leaky_integrator import LeakyIntegrator
from narx.errors import UserError
from narx.method import SegmentSignals

RATE_HZ = 100.0


@pytest.fixture(scope="module")
def signals():
    rates = 3.0 * np.random.default_rng(0).normal(size=(400, 3))
    rates[100:200] *= np.geomspace(1.0, 0.01, 100)[:, None]  # comes to rest
    return SegmentSignals("thigh", RATE_HZ, rates, np.full((400, 3), np.nan))


def written_out(rates, leak, by_angle, by_rate):
    angles = np.zeros_like(rates)
    for k in range(1, len(rates)):
        size = max(np.linalg.norm(rates[k]), 0.2)
        for axis in range(3):
            before = angles[k - 1, axis]
            now = leak * (1.0 + by_angle * (np.degrees(before) / 30.0) ** 2)
            now *= (size / 2.0) ** by_rate
            turned = before + 0.5 / RATE_HZ * (rates[k, axis] + rates[k - 1, axis])
            angles[k, axis] = turned / (1.0 + now / RATE_HZ)
    return angles


@pytest.mark.parametrize(
    ("by_angle", "by_rate"), [(0.0, 0.0), (3.0, 0.0), (0.0, 1.0), (0.0, -1.0), (2.0, 0.5)]
)
def test_it_is_the_recursion_written_out(signals, by_angle, by_rate):
    method = LeakyIntegrator(0.7, by_angle=by_angle, by_rate=by_rate)
    expected = written_out(signals.axis_rates_rad_s, 0.7, by_angle, by_rate)
    np.testing.assert_allclose(method.estimate(signals), expected, atol=1e-12)
    step = method.recursion(RATE_HZ, 1, None)
    angles, _ = step.advance(signals.axis_rates_rad_s, np.array([0, signals.n_samples]))
    np.testing.assert_allclose(angles, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"by_angle": -1}, "by_angle is -1, expected a number from 0 to 100"),
        ({"by_rate": float("nan")}, "by_rate is nan, expected a number from -1 to 100"),
        ({"coupled": True, "tracker": True, "by_rate": 1}, "a tracker needs a constant leak"),
    ],
)
def test_nonsense_is_refused(parameters, message):
    with pytest.raises(UserError, match=message):
        LeakyIntegrator(**parameters)
