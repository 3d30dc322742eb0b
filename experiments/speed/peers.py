"""Peers of the engine: the same work done by other libraries and by compiled C.

Each function prepares a peer and returns a callable that does the work once, or None if the
peer is not installed.
"""

import importlib.util
from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from torch import Tensor

from narx.types import FloatArray

Work = Callable[[], Any]


def installed(module: str) -> bool:
    """Return whether a peer can be imported.

    Parameters
    ----------
    module : str
        Name of the module.

    Returns
    -------
    bool
        True if it is installed.
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
    """Run channels through a scripted torch loop, time first, the fastest layout.

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
