"""Conversion of tensors of any batch shape to the flat float64 arrays of the kernels."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from narx.kernels import loops
from narx.kernels.sizes import SCALAR, VECTOR, length, run_time_length
from narx.network.structure import NarxStructure
from narx.types import FloatArray

Size = tuple[int, ...] | NDArray[np.uint8]

# the kernels specialise on the type of this argument: None selects the rational tanh
EXACT = {"rational": None, "exact": True}


_DEFAULT = NarxStructure()


@lru_cache
def kernel_shape(structure: NarxStructure) -> tuple[Size, ...]:
    """Encode the sizes of a network as lengths (`narx.kernels.sizes`).

    The default structure has machine code of its own. That of the other structures serves any
    number of hidden neurons, and, with other delays or inputs than the default's, all sizes. A fit
    of six neurons takes as long as with machine code of its own, a fourth longer if the delays are
    lengths at run time, too; machine code of its own would take twenty seconds to compile.

    Parameters
    ----------
    structure : NarxStructure
        Sizes of the network.

    Returns
    -------
    tuple
        Lengths of each of the structure's sizes.
    """
    return _lengths(structure, *structure.sizes[1:])


@lru_cache
def feature_shape(structure: NarxStructure) -> tuple[Size, ...]:
    """Encode the sizes of a network on lagged windows as lengths, as `kernel_shape`.

    Parameters
    ----------
    structure : NarxStructure
        Sizes of the network.

    Returns
    -------
    tuple
        Lengths of hidden neurons and features.
    """
    return _lengths(structure, structure.n_features)


def _lengths(structure: NarxStructure, *others: int) -> tuple[Size, ...]:
    neurons = length if structure == _DEFAULT else run_time_length
    known = length if structure.sizes[1:] == _DEFAULT.sizes[1:] else run_time_length
    return neurons(structure.hidden), *(known(n) for n in others)


def lanes_for(n_sequences: int) -> tuple[int, ...]:
    """Choose how many sequences run in parallel: one or eight.

    Parameters
    ----------
    n_sequences : int
        Number of sequences.

    Returns
    -------
    tuple of int
        A tuple whose length is the number of lanes.
    """
    return SCALAR if n_sequences == 1 else VECTOR


def broadcast(
    weights: Tensor, inputs: Tensor, state: Tensor | None, structure: NarxStructure
) -> tuple[Tensor, Tensor, Tensor]:
    """Check last dimensions and expand the leading ones; a missing state is zero.

    Parameters
    ----------
    weights : Tensor, shape (..., P)
        Flat weights.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs.
    state : Tensor, shape (..., n_state), or None
        State before the first sample.
    structure : NarxStructure
        Sizes of the network.

    Returns
    -------
    weights, inputs, state : Tensor
        With the same leading dimensions.

    Raises
    ------
    ValueError
        If a last dimension does not fit the structure.
    """
    if inputs.ndim < 2 or inputs.shape[-1] != structure.n_inputs:
        raise ValueError(f"inputs {tuple(inputs.shape)}, expected (..., N, {structure.n_inputs})")
    if weights.shape[-1:] != (structure.n_weights,):
        raise ValueError(f"weights {tuple(weights.shape)}, expected (..., {structure.n_weights})")
    if state is None:
        state = inputs.new_zeros(structure.n_state)
    if state.shape[-1:] != (structure.n_state,):
        raise ValueError(f"state {tuple(state.shape)}, expected (..., {structure.n_state})")
    # torch's broadcast_shapes imports a package for symbolic shapes, which takes half a second
    lead = np.broadcast_shapes(weights.shape[:-1], inputs.shape[:-2], state.shape[:-1])
    return (
        weights.expand(*lead, structure.n_weights),
        inputs.expand(*lead, *inputs.shape[-2:]),
        state.expand(*lead, structure.n_state),
    )


def compiled_for(tensor: Tensor) -> bool:
    """Return whether the compiled kernels can process a tensor.

    Parameters
    ----------
    tensor : Tensor
        Input of a network.

    Returns
    -------
    bool
        False on other devices than the CPU, where the kernels are not available, and inside a
        transform of `torch.func`, whose tensors have no memory to read from.
    """
    transformed = torch._C._are_functorch_transforms_active()
    return loops.AVAILABLE and tensor.device.type == "cpu" and not transformed


def gradients_by_torch(
    run: Callable[..., Any], inputs: Sequence[Tensor], d_outputs: Sequence[Tensor]
) -> list[Tensor | None]:
    """Differentiate plain torch operations so that the gradients can be differentiated again.

    Parameters
    ----------
    run : callable
        Inputs to outputs, in torch operations.
    inputs : sequence of Tensor
        As a `torch.autograd.Function` saved them.
    d_outputs : sequence of Tensor
        Gradients of the outputs.

    Returns
    -------
    list of Tensor or None
        Gradient of each input, with a graph; None where none is required.
    """
    wanted = [tensor for tensor in inputs if tensor.requires_grad]
    found = iter(
        torch.autograd.grad(run(*inputs), wanted, d_outputs, create_graph=True, allow_unused=True)
    )
    return [next(found) if tensor.requires_grad else None for tensor in inputs]


def flat(tensor: Tensor, keep: int) -> FloatArray:
    """Flatten all but the last `keep` dimensions into one.

    Parameters
    ----------
    tensor : Tensor, shape (..., *last)
        Numbers of any floating type.
    keep : int
        Number of last dimensions to keep.

    Returns
    -------
    ndarray, shape (B, *last)
        Contiguous float64.
    """
    array = tensor.detach().to(torch.float64).numpy()
    n_rows = int(np.prod(tensor.shape[: tensor.ndim - keep], dtype=np.int64))
    return np.ascontiguousarray(array).reshape(n_rows, *tensor.shape[tensor.ndim - keep :])


def flat_weights(weights: Tensor) -> FloatArray:
    """Flatten as `flat` does; weights shared by all sequences stay one row.

    Parameters
    ----------
    weights : Tensor, shape (..., P)
        Flat weights, expanded or not.

    Returns
    -------
    ndarray, shape (B, P) or (1, P)
        Contiguous float64.
    """
    if all(s == 0 or n == 1 for n, s in zip(weights.shape[:-1], weights.stride(), strict=False)):
        shared = weights[(0,) * (weights.ndim - 1)] if weights.numel() else weights.new_zeros(1)
        return flat(shared, 1).reshape(1, -1)
    return flat(weights, 1)


def back(array: FloatArray, shape: tuple[int, ...], like: Tensor) -> Tensor:
    """Convert an array to a tensor of the caller's shape and type.

    Parameters
    ----------
    array : ndarray
        Numbers from a kernel.
    shape : tuple of int
        Shape of the result.
    like : Tensor
        Tensor of the result's type.

    Returns
    -------
    Tensor
        The same numbers.
    """
    return torch.from_numpy(array).reshape(shape).to(like.dtype)


@lru_cache  # every evaluation of a cost asks for it
def in_groups(n_sequences: int, n_starts: int) -> tuple[tuple[int, ...], NDArray[np.int64], slice]:
    """Arrange sequences and starts in groups of lanes, each a unit of work for a thread.

    Parameters
    ----------
    n_sequences : int
        Number of sequences.
    n_starts : int
        Number of starts, each run over all sequences.

    Returns
    -------
    lanes : tuple of int
        A tuple whose length is the number of lanes, W.
    groups : ndarray of int, shape (groups, runs, W, 2)
        What a lane runs, one after another: sequence and start. A single start has sequences side
        by side, several starts are side by side themselves.
    idle : slice
        Lanes of the last group that repeat the last sequence or start; their sums do not count.
        Lanes without a sequence would make every sample of the group need a weight.
    """
    if n_starts == 1:
        if lanes_for(n_sequences) == SCALAR:
            return one_after_another(n_sequences)
        sequences, idle = in_lanes(n_sequences, len(VECTOR))
        alone = np.zeros_like(sequences)
        return VECTOR, np.stack([sequences, alone], axis=-1)[:, None], idle
    starts, idle = in_lanes(n_starts, len(VECTOR))
    groups = np.empty((len(starts), n_sequences, len(VECTOR), 2), dtype=np.int64)
    groups[..., 0] = np.arange(n_sequences)[:, None]
    groups[..., 1] = starts[:, None]
    return VECTOR, groups, idle


@lru_cache
def one_after_another(n_sequences: int) -> tuple[tuple[int, ...], NDArray[np.int64], slice]:
    """Arrange the sequences of one start in groups of a single lane, as `in_groups`.

    Parameters
    ----------
    n_sequences : int
        Number of sequences.

    Returns
    -------
    lanes, groups, idle
        As `in_groups`, with one group of all sequences.
    """
    groups = np.zeros((1, n_sequences, 1, 2), dtype=np.int64)
    groups[0, :, 0, 0] = np.arange(n_sequences)
    # a single lane has its sums in all eight
    return SCALAR, groups, slice(len(VECTOR), None)


def in_lanes(n: int, width: int) -> tuple[NDArray[np.int64], slice]:
    """Arrange the numbers below `n` in rows of `width`.

    Parameters
    ----------
    n : int
        Number of elements.
    width : int
        Elements per row.

    Returns
    -------
    numbers : ndarray of int, shape (rows, width)
        The last row is padded with the last number.
    padding : slice
        Where in the last row.
    """
    rows = -(-n // width)
    numbers = np.minimum(np.arange(rows * width), n - 1).reshape(rows, width)
    return numbers, slice(n - (rows - 1) * width, None)


def grouped(rows: FloatArray) -> FloatArray:
    """Arrange the rows of sequences in groups of as many as run side by side (`lanes_for`).

    Parameters
    ----------
    rows : ndarray, shape (B, S)
        A row for each sequence.

    Returns
    -------
    ndarray, shape (groups, S, lanes)
        The last group is padded with the last sequence.
    """
    at, _ = in_lanes(len(rows), len(lanes_for(len(rows))))
    return rows[at].transpose(0, 2, 1).copy()
