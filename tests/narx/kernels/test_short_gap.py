"""Rates that are linear over a gap are interpolated without error."""

import numpy as np

from narx.kernels import short_gap

INTERVAL_S = 0.01
# only other kernels call the compiled form
interpolate = short_gap.interpolate.py_func


def test_an_angle_that_is_quadratic_in_time_is_continued_exactly():
    gap_s, at_s = 0.2, np.arange(-3, 21) * INTERVAL_S
    slope, last, begin = np.array([[3.0], [-5.0], [0.0]]), np.array([[1.0], [0.5], [2.0]]), 0.3
    rates = last + slope * at_s
    angles = begin + last * at_s + 0.5 * slope * at_s**2
    newest = slice(3, None, -1)
    past_rates, past_angles = rates[:, newest].copy(), angles[:, newest].copy()
    means = np.empty((2, 3))
    now = (last + slope * (gap_s + INTERVAL_S))[:, 0]
    interpolate(gap_s, INTERVAL_S, now, past_rates, past_angles, means)
    np.testing.assert_allclose(past_rates, rates[:, :-5:-1], atol=1e-12)
    np.testing.assert_allclose(past_angles, angles[:, :-5:-1], atol=1e-12)
    np.testing.assert_allclose(means, [angles[:, 4:].mean(axis=1), rates[:, 4:].mean(axis=1)])
