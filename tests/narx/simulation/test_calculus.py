"""Stencils against polynomials and sines."""

import numpy as np
import pytest

from narx.simulation.calculus import (
    EDGE,
    derivative,
    integral,
    second_derivative,
    smooth_step,
)

RATE_HZ = 500.0
TIME_S = np.arange(-200, 201) / RATE_HZ
INNER = slice(EDGE, -EDGE)


@pytest.mark.parametrize("power", range(8))
def test_exact_for_polynomials(power):
    x = TIME_S[:, None] ** [power, power]
    slope = power * TIME_S ** max(power - 1, 0)
    curvature = power * (power - 1) * TIME_S ** max(power - 2, 0)
    np.testing.assert_allclose(derivative(x, RATE_HZ)[INNER, 1], slope[INNER], atol=1e-10)
    np.testing.assert_allclose(second_derivative(x, RATE_HZ)[INNER, 0], curvature[INNER], atol=1e-8)
    back = integral(x, RATE_HZ)[:, 0]
    primitive = TIME_S ** (power + 1) / (power + 1)
    np.testing.assert_allclose(
        (back - back[EDGE])[INNER], (primitive - primitive[EDGE])[INNER], atol=1e-12
    )


@pytest.mark.parametrize(("frequency_hz", "error"), [(5.0, 1e-9), (20.0, 2e-7)])
def test_second_derivative_of_a_sine(frequency_hz, error):
    omega = 2 * np.pi * frequency_hz
    curvature = second_derivative(np.sin(omega * TIME_S), RATE_HZ)
    expected = -(omega**2) * np.sin(omega * TIME_S)
    np.testing.assert_allclose(curvature[INNER], expected[INNER], atol=error * omega**2)


def test_integral_undoes_the_derivative():
    x = np.exp(np.sin(9.0 * TIME_S))
    back = integral(derivative(x, RATE_HZ), RATE_HZ)
    np.testing.assert_allclose((back - back[EDGE])[INNER], (x - x[EDGE])[INNER], atol=1e-9)


def test_smooth_step_has_three_continuous_derivatives():
    x = np.linspace(-0.5, 1.5, 4001)
    step = smooth_step(x)
    assert step[0] == 0.0
    assert step[-1] == 1.0
    assert np.all(np.diff(step) >= -1e-12)
    np.testing.assert_allclose(step + smooth_step(1.0 - x), 1.0, atol=1e-12)
    h = x[1] - x[0]
    third = np.diff(step, 3) / h**3
    # a jump of the third derivative would not shrink with the step
    assert np.abs(np.diff(third)).max() < 900 * h
