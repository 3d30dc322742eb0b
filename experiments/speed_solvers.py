"""Least-squares solvers of other libraries on the open-loop fit of a network."""

from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import least_squares

from experiments.speed_peers import installed

FloatArray = NDArray[np.float64]
Work = Callable[[], Any]


def _features(v: FloatArray, p: FloatArray) -> FloatArray:
    def lagged(x: FloatArray, lag: int) -> FloatArray:
        return np.concatenate([np.zeros(lag), x[: len(x) - lag]])

    return np.column_stack([v, lagged(v, 1), lagged(p, 1), lagged(p, 2)])


def scipy_open_loop(v: FloatArray, target: FloatArray, evaluations: int) -> Callable[..., Any]:
    """MINPACK's Levenberg-Marquardt with the same analytic Jacobian.

    Parameters
    ----------
    v, target : ndarray, shape (N,)
        Input and measured output.
    evaluations : int
        Evaluations of the residuals.

    Returns
    -------
    callable
        Trains from the weights it is given; `cost` and `nfev` in what it returns.
    """
    x = _features(v, target)

    def hidden(w: FloatArray) -> FloatArray:
        return np.tanh(x @ w[:12].reshape(3, 4).T + w[12:15])

    def residuals(w: FloatArray) -> FloatArray:
        return hidden(w) @ w[15:18] + w[18] - target

    jac = np.ones((len(v), 19))

    def jacobian(w: FloatArray) -> FloatArray:
        h = hidden(w)
        d = w[15:18] * (1.0 - h * h)
        jac[:, :12] = (d[:, :, None] * x[:, None, :]).reshape(len(x), 12)
        jac[:, 12:15], jac[:, 15:18] = d, h
        return jac

    def train(start: FloatArray, tolerance: float = 0.0) -> Any:
        return least_squares(
            residuals,
            start,
            jacobian,
            method="lm",
            max_nfev=evaluations,
            ftol=tolerance or 1e-15,
            xtol=1e-15,
            gtol=1e-15,
        )

    return train


def torch_levenberg_marquardt_open_loop(
    v: FloatArray, target: FloatArray, iterations: int
) -> Callable[[FloatArray], Any] | None:
    """Train by torch-levenberg-marquardt on the lagged features.

    Parameters
    ----------
    v, target : ndarray, shape (N,)
        Input and measured output.
    iterations : int
        Training steps.

    Returns
    -------
    callable or None
        Trains from the weights it is given; returns the costs (mean square) by step.
    """
    if not installed("torch_levenberg_marquardt"):
        return None
    import torch_levenberg_marquardt.training as tlm

    x = torch.from_numpy(_features(v, target))
    y = torch.from_numpy(target)[:, None]

    def train(start: FloatArray) -> list[float]:
        model = torch.nn.Sequential(
            torch.nn.Linear(4, 3), torch.nn.Tanh(), torch.nn.Linear(3, 1)
        ).double()
        parts = (start[:12].reshape(3, 4), start[12:15], start[15:18][None], start[18:])
        with torch.no_grad():
            for parameter, part in zip(model.parameters(), parts, strict=True):
                parameter.copy_(torch.from_numpy(part.copy()))
        module = tlm.LevenbergMarquardtModule(model)
        costs = []
        for _ in range(iterations):
            _, loss, stop, _ = module.training_step(x, y)
            costs.append(float(loss))
            if stop:
                break
        return costs

    return train


def optimistix_open_loop(
    v: FloatArray, target: FloatArray, iterations: int
) -> Callable[[FloatArray], Any] | None:
    """Train by optimistix' Levenberg-Marquardt, jitted.

    Parameters
    ----------
    v, target : ndarray, shape (N,)
        Input and measured output.
    iterations : int
        Steps.

    Returns
    -------
    callable or None
        Trains from the weights it is given; returns the cost (mean square).
    """
    if not (installed("jax") and installed("optimistix")):
        return None
    import jax
    import jax.numpy as jnp
    import optimistix

    jax.config.update("jax_enable_x64", True)
    x, y = jnp.asarray(_features(v, target)), jnp.asarray(target)

    def residuals(w: Any, _: Any) -> Any:
        h = jnp.tanh(x @ w[:12].reshape(3, 4).T + w[12:15])
        return h @ w[15:18] + w[18] - y

    solver: Any = optimistix.LevenbergMarquardt(rtol=1e-15, atol=1e-15)

    @jax.jit
    def solve(start: Any) -> Any:
        solution: Any = optimistix.least_squares(
            residuals, solver, start, max_steps=iterations, throw=False
        )
        return solution.value

    def train(start: FloatArray) -> float:
        w = jax.block_until_ready(solve(jnp.asarray(start)))
        return float(jnp.mean(residuals(w, None) ** 2))

    return train
