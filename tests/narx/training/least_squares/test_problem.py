"""The prior of a least-squares problem, by torch operations and as products."""

import numpy as np
import pytest
import torch

from narx.training.least_squares.problem import TowardsPrior


class Linear:
    """Residuals ``A w - b``."""

    n_weights, n_residuals, total_weight = 3, 8, 5.0

    def __init__(self):
        self.a, self.b = torch.from_numpy(np.random.default_rng(0).normal(size=(8, 4))).split(
            [3, 1], dim=1
        )

    def residuals(self, weights):
        return self.a @ weights - self.b[:, 0]

    def products(self, weights):
        rows = [torch.column_stack([self.a, self.residuals(torch.from_numpy(w))]) for w in weights]
        return np.array([(r.T @ r).numpy() for r in rows])


def test_a_prior_adds_its_strength_times_the_squared_distance():
    centre, strength = np.array([1.0, -2.0, 0.5]), np.array([4.0, 0.25, 9.0])
    problem = TowardsPrior(Linear(), centre, strength)
    starts = np.array([[0.0, 0.0, 0.0], [2.0, 1.0, -1.0]])
    products = problem.products(starts)
    for start, found in zip(starts, products, strict=True):
        weights = torch.from_numpy(start)
        own = float(Linear().residuals(weights).square().sum())
        squares = own + np.sum(strength * (start - centre) ** 2)
        assert found[-1, -1] == pytest.approx(squares)
        assert float(problem.residuals(weights).square().sum()) == pytest.approx(squares)
        rows = torch.column_stack(
            [torch.func.jacfwd(problem.residuals)(weights), problem.residuals(weights)]
        )
        np.testing.assert_allclose(np.tril(found), np.tril((rows.T @ rows).numpy()), atol=1e-12)
    assert (problem.n_weights, problem.n_residuals, problem.total_weight) == (3, 8, 5.0)
