"""Damping after a step, by the rule of Nielsen (1999).

K. Madsen, H. B. Nielsen, O. Tingleff, Methods for Non-Linear Least Squares Problems (2004),
eq. (2.21): mu := mu max(1/3, 1 - (2 rho - 1)^3), nu := 2 if the gain ratio rho is positive; else
mu := mu nu, nu := 2 nu.
"""

import pytest

from narx.kernels import lm_step

# inside the kernels it has no wrapper for Python
adapt = lm_step.adapt.py_func


@pytest.mark.parametrize(
    ("gain", "factor"),
    [
        (0.0, 2.0),
        (0.25, 1.125),
        (0.5, 1.0),
        (0.75, 0.875),
        (0.9, 0.488),
        (1.0, 1 / 3),
        (2.0, 1 / 3),
    ],
)
def test_a_step_that_is_kept(gain, factor):
    assert adapt(6.0, 16.0, True, gain, 1e-9) == pytest.approx((6.0 * factor, 2.0))


def test_steps_that_are_rejected_in_a_row():
    mu, growth, seen = 1.0, 2.0, []
    for _ in range(4):
        mu, growth = adapt(mu, growth, False, -1.0, 1e-9)
        seen.append((mu, growth))
    assert seen == [(2.0, 4.0), (8.0, 8.0), (64.0, 16.0), (1024.0, 32.0)]


def test_there_is_a_smallest():
    assert adapt(1e-3, 2.0, True, 1.0, 1e-2)[0] == 1e-2
