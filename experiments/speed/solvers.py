"""Least-squares solvers of other libraries on the open-loop fit of a network.

Each is a function ``train(start, level)``: from these weights, for a fixed number of steps, or
until the mean square reaches the level. MINPACK and optimistix have no such limit; the former is
stopped by an exception, the stopping test of the latter is extended.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from scipy.optimize import least_squares

from narx.experiments.speed.peers import installed
from narx.types import FloatArray


@dataclass(frozen=True)
class Trained:
    """Result of a solver.

    Parameters
    ----------
    mean_square : float
        Mean square of the residuals at the end.
    n_steps : int
        Evaluations (scipy) or steps.
    """

    mean_square: float
    n_steps: int


Train = Callable[[FloatArray, float], Trained]


class _LevelReached(Exception):
    pass


def _features(v: FloatArray, p: FloatArray) -> FloatArray:
    def lagged(x: FloatArray, lag: int) -> FloatArray:
        return np.concatenate([np.zeros(lag), x[: len(x) - lag]])

    return np.column_stack([v, lagged(v, 1), lagged(p, 1), lagged(p, 2)])


def scipy_open_loop(v: FloatArray, target: FloatArray, evaluations: int) -> Train:
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
        Trains.
    """
    x = _features(v, target)

    def hidden(w: FloatArray) -> FloatArray:
        return np.tanh(x @ w[:12].reshape(3, 4).T + w[12:15])

    jac = np.ones((len(v), 19))

    def jacobian(w: FloatArray) -> FloatArray:
        h = hidden(w)
        d = w[15:18] * (1.0 - h * h)
        jac[:, :12] = (d[:, :, None] * x[:, None, :]).reshape(len(x), 12)
        jac[:, 12:15], jac[:, 15:18] = d, h
        return jac

    def train(start: FloatArray, level: float = 0.0) -> Trained:
        done = Trained(np.nan, 0)

        def residuals(w: FloatArray) -> FloatArray:
            nonlocal done
            errors = hidden(w) @ w[15:18] + w[18] - target
            mean_square = float(errors @ errors) / len(errors)
            done = Trained(mean_square, done.n_steps + 1)
            if mean_square <= level:
                raise _LevelReached
            return errors

        try:
            solution: Any = least_squares(
                residuals,
                start,
                jacobian,
                method="lm",
                max_nfev=evaluations,
                ftol=1e-15,
                xtol=1e-15,
                gtol=1e-15,
            )
        except _LevelReached:
            return done
        return Trained(2.0 * float(solution.cost) / len(v), int(solution.nfev))

    return train


def torch_levenberg_marquardt_open_loop(
    v: FloatArray, target: FloatArray, iterations: int
) -> Train | None:
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
        Trains; None if the library is not installed.
    """
    if not installed("torch_levenberg_marquardt"):
        return None
    import torch_levenberg_marquardt.training as tlm

    x = torch.from_numpy(_features(v, target))
    y = torch.from_numpy(target)[:, None]

    def train(start: FloatArray, level: float = 0.0) -> Trained:
        model = torch.nn.Sequential(
            torch.nn.Linear(4, 3), torch.nn.Tanh(), torch.nn.Linear(3, 1)
        ).double()
        parts = (start[:12].reshape(3, 4), start[12:15], start[15:18][None], start[18:])
        with torch.no_grad():
            for parameter, part in zip(model.parameters(), parts, strict=True):
                parameter.copy_(torch.from_numpy(part.copy()))
        module = tlm.LevenbergMarquardtModule(model)
        done, stop = Trained(np.nan, 0), False
        while done.n_steps < iterations and not stop and not done.mean_square <= level:
            _, loss, stop, _ = module.training_step(x, y)
            done = Trained(float(loss), done.n_steps + 1)
        return done

    return train


def optimistix_open_loop(v: FloatArray, target: FloatArray, iterations: int) -> Train | None:
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
        Trains; None if the library is not installed.
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

    class UntilLevel(optimistix.LevenbergMarquardt):
        def terminate(self, fn: Any, y: Any, args: Any, options: Any, state: Any, tags: Any) -> Any:
            done, result = super().terminate(fn, y, args, options, state, tags)
            low = 2.0 * state.f_info.as_min() <= options["level"] * len(target)
            return done | (low & (state.num_accepted_steps > 0)), result

    make: Any = UntilLevel
    solver = make(rtol=1e-15, atol=1e-15)

    @jax.jit
    def solve(start: Any, level: Any) -> Any:
        solution: Any = optimistix.least_squares(
            residuals,
            solver,
            start,
            options={"level": level},
            max_steps=iterations,
            throw=False,
        )
        errors = residuals(solution.value, None)
        return jnp.mean(errors**2), solution.stats["num_steps"]

    def train(start: FloatArray, level: float = 0.0) -> Trained:
        mean_square, n = jax.block_until_ready(solve(jnp.asarray(start), level))
        return Trained(float(mean_square), int(n))

    return train
