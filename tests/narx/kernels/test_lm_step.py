"""Damping after a step, by the rule of Nielsen (1999).

K. Madsen, H. B. Nielsen, O. Tingleff, Methods for Non-Linear Least Squares Problems (2004),
eq. (2.21): mu := mu max(1/3, 1 - (2 rho - 1)^3), nu := 2 if the gain ratio rho is positive; else
mu := mu nu, nu := 2 nu.
"""

import numpy as np
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


@pytest.mark.parametrize(
    ("stopping", "code"),
    [
        # gradient, step, cost change, squares
        ((0.0, 0.0, 0.0, 0.0), lm_step.RUNNING),
        ((0.091, 0.0, 0.0, 0.0), lm_step.GRADIENT),  # 0.9, relative to the cost before, 10
        ((0.089, 0.0, 0.0, 0.0), lm_step.RUNNING),
        ((0.0, 0.011, 0.0, 0.0), lm_step.STEP),  # 0.05, relative to the weights before, 5
        ((0.0, 0.009, 0.0, 0.0), lm_step.RUNNING),
        ((0.0, 0.0, 0.101, 0.0), lm_step.COST_CHANGE),  # from 10 to 9
        ((0.0, 0.0, 0.099, 0.0), lm_step.RUNNING),
        ((0.0, 0.0, 0.0, 18.1), lm_step.COST),  # twice the cost
        ((0.0, 0.0, 0.0, 17.9), lm_step.RUNNING),
    ],
)
def test_limits_of_an_accepted_step(stopping, code):
    trial_products = np.zeros((1, 3, 3))
    trial_products[0, 2, 2] = 18.0
    weights, cost, mu = np.array([[3.0, 4.0]]), np.array([10.0]), np.array([1e-3])
    codes, kept = np.array([lm_step.RUNNING]), np.empty(1, dtype=np.bool_)
    products = np.zeros((1, 3, 3))
    products[0, 2, 2] = 20.0
    lm_step.decide(
        np.array([0]), np.array([[3.03, 4.04]]), trial_products, np.array([1.0]), np.array([0.9]),
        np.arange(2), np.zeros(1), stopping, (1e-18, 1e10),
        weights, products, cost, mu, np.array([2.0]), codes, kept,
    )  # fmt: skip
    assert kept[0]
    assert codes[0] == code
    assert cost[0] == 9.0
    assert mu[0] == pytest.approx(1e-3 / 3)  # as predicted
    np.testing.assert_array_equal(weights, [[3.03, 4.04]])
    assert products[0, 2, 2] == 18.0
