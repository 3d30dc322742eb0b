"""What the engine is compared with: the same work by other libraries, and by a C compiler.

Each function prepares a peer and returns a callable that does the work once, or None if the
peer is not installed.
"""

import ctypes
import importlib.util
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import least_squares
from torch import Tensor

FloatArray = NDArray[np.float64]
Work = Callable[[], Any]

_POINTER = ctypes.POINTER(ctypes.c_double)


def installed(module: str) -> bool:
    """Tell whether a peer can be imported.

    Parameters
    ----------
    module : str
        Its name.

    Returns
    -------
    bool
        True if it is there.
    """
    return importlib.util.find_spec(module) is not None


def _torch_cell(weights: Tensor, v: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
    x = torch.cat([v.unsqueeze(0), state])  # v_k, v_{k-1}, p_{k-1}, p_{k-2} by channel
    hidden = torch.tanh(weights[:12].reshape(3, 4) @ x + weights[12:15, None])
    p = weights[15:18] @ hidden + weights[18]
    return p, torch.stack([v, p, state[1]])


def _torch_loop(weights: Tensor, inputs: Tensor) -> Tensor:
    state = torch.zeros(3, inputs.shape[1], dtype=inputs.dtype)
    outputs: list[Tensor] = []
    for k in range(inputs.shape[0]):
        p, state = _torch_cell(weights, inputs[k], state)
        outputs.append(p)
    return torch.stack(outputs)


def torch_gradient(weights: FloatArray, v: FloatArray, target: FloatArray, script: bool) -> Work:
    """Back-propagation through a loop of torch operations: the gradient alone.

    Parameters
    ----------
    weights : ndarray, shape (19,)
        Weights of the default network.
    v, target : ndarray, shape (N,)
        Input and target.
    script : bool
        Compile the loop by TorchScript.

    Returns
    -------
    callable
        Returns the gradient.
    """
    w = torch.tensor(weights, requires_grad=True)
    inputs, wanted = torch.from_numpy(v)[:, None], torch.from_numpy(target)[:, None]
    loop = torch.jit.script(_torch_loop) if script else _torch_loop

    def work() -> FloatArray:
        error = loop(w, inputs) - wanted
        (gradient,) = torch.autograd.grad(0.5 * (error * error).sum(), w)
        return gradient.numpy()

    return work


def torchscript_rollout(weights: FloatArray, v: FloatArray) -> Work:
    """Run channels through a scripted torch loop, time first as suits it best.

    Parameters
    ----------
    weights : ndarray, shape (19,)
        Weights of the default network.
    v : ndarray, shape (channels, N)
        Inputs.

    Returns
    -------
    callable
        Returns the outputs.
    """
    loop = torch.jit.script(_torch_loop)
    w, inputs = torch.from_numpy(weights), torch.from_numpy(np.ascontiguousarray(v.T))

    def work() -> Tensor:
        with torch.no_grad():
            return loop(w, inputs)

    return work


def jax_jacobian(
    weights: FloatArray, v: FloatArray, target: FloatArray, unroll: int
) -> Work | None:
    """Forward-mode Jacobian of a jitted scan, reduced to the normal matrix.

    Parameters
    ----------
    weights : ndarray, shape (19,)
        Weights of the default network.
    v, target : ndarray, shape (N,)
        Input and target.
    unroll : int
        Steps of the scan that are unrolled.

    Returns
    -------
    callable or None
        Returns normal matrix and gradient.
    """
    if not installed("jax"):
        return None
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def outputs(w: Any, inputs: Any) -> Any:
        w1, b1, w2 = w[:12].reshape(3, 4), w[12:15], w[15:18]

        def step(carry: Any, now: Any) -> Any:
            v1, p1, p2 = carry
            p = w2 @ jnp.tanh(w1 @ jnp.stack([now, v1, p1, p2]) + b1) + w[18]
            return (now, p, p1), p

        zero = jnp.zeros(())
        return jax.lax.scan(step, (zero, zero, zero), inputs, unroll=unroll)[1]

    @jax.jit
    def reduce(w: Any, inputs: Any, wanted: Any) -> Any:
        jac = jax.jacfwd(outputs)(w, inputs)
        return jac.T @ jac, jac.T @ (outputs(w, inputs) - wanted)

    arguments = [jnp.asarray(a) for a in (weights, v, target)]
    return lambda: jax.block_until_ready(reduce(*arguments))


def pyrenn_jacobian(v: FloatArray, target: FloatArray) -> Work | None:
    """Real-time recurrent learning of pyrenn on the same structure.

    Parameters
    ----------
    v, target : ndarray, shape (N,)
        Input and target.

    Returns
    -------
    callable or None
        Returns Jacobian, cost and errors.
    """
    if not installed("pyrenn"):
        return None
    import pyrenn

    net = pyrenn.CreateNN([1, 3, 1], dIn=[0, 1], dIntern=[], dOut=[1, 2])
    data, net = pyrenn.prepare_data(v, target, net)
    return lambda: pyrenn.RTRL(net, data)


class CompiledC:
    """The recurrence in C, compiled for this machine.

    Parameters
    ----------
    folder : Path
        Where the library goes.
    """

    def __init__(self, folder: Path) -> None:
        library = folder / "speed_peer.so"
        source = Path(__file__).with_name("speed_peer.c")
        command = [
            "gcc",
            "-O3",
            "-march=native",
            "-shared",
            "-fPIC",
            "-o",
            str(library),
            str(source),
        ]
        subprocess.run(command, check=True, capture_output=True)
        self._library = ctypes.CDLL(str(library))

    @staticmethod
    def available() -> bool:
        """Tell whether there is a compiler.

        Returns
        -------
        bool
            True if gcc is on the path.
        """
        return shutil.which("gcc") is not None

    def closed_loop_products(self, w: FloatArray, v: FloatArray, target: FloatArray) -> Work:
        """Accumulate the normal equations of the closed loop.

        Parameters
        ----------
        w : ndarray, shape (19,)
            Weights.
        v, target : ndarray, shape (N,)
            Input and target.

        Returns
        -------
        callable
            Returns products (24, 24), row 19 the residuals'.
        """
        products = np.zeros((24, 24))
        arguments = [_pointer(w), _pointer(v), _pointer(target), ctypes.c_long(len(v))]

        def work() -> FloatArray:
            self._library.closed_loop_products(*arguments, _pointer(products))
            return products

        return work

    def rollout(self, w: FloatArray, v: FloatArray) -> Work:
        """Run channels.

        Parameters
        ----------
        w : ndarray, shape (19,)
            Weights.
        v : ndarray, shape (channels, N)
            Inputs.

        Returns
        -------
        callable
            Returns the outputs.
        """
        outputs = np.empty_like(v)
        n_channels, n = (ctypes.c_long(size) for size in v.shape)

        def one() -> FloatArray:
            self._library.rollout(_pointer(w), _pointer(v), n, _pointer(outputs))
            return outputs

        def many() -> FloatArray:
            arguments = _pointer(w), _pointer(v), n_channels, n, _pointer(outputs)
            self._library.rollout_many(*arguments)
            return outputs

        return one if len(v) == 1 else many


def _pointer(array: FloatArray) -> Any:
    return array.ctypes.data_as(_POINTER)


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
