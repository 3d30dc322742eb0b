"""Starts that have reached the same minimum, of which one need be trained further."""

import numpy as np
from numpy.typing import NDArray

from narx.network.structure import NarxStructure
from narx.types import BoolArray, FloatArray

# largest difference of two networks in the same minimum, relative to the largest weight of a kind:
# a solver that ends where the cost changes by 1e-6 leaves weights uncertain by about the root
_SAME = 1e-3


def first_alike(weights: FloatArray, structure: NarxStructure) -> NDArray[np.int64]:
    """Find for each network the first that is the same.

    The order of the hidden neurons does not change a network, nor do the signs of all weights of a
    neuron together, since tanh is odd.

    Parameters
    ----------
    weights : ndarray, shape (R, P)
        Weights of each network.
    structure : NarxStructure
        Sizes of the networks.

    Returns
    -------
    ndarray of int, shape (R,)
        Number of the first network that is the same: its own if there is none before it, or if its
        weights are not finite.
    """
    ordered = _in_order(weights, structure)
    first = np.arange(len(weights))
    finite: BoolArray = np.asarray(np.isfinite(weights).all(axis=1))
    for i in np.flatnonzero(finite):
        others = np.flatnonzero(finite[:i] & (first[:i] == np.arange(i)))
        size = np.abs(ordered[i]).max(axis=0)
        near = np.abs(ordered[others] - ordered[i]) <= _SAME * size
        alike = others[near.all(axis=(1, 2))]
        if len(alike):
            first[i] = alike[0]
    return first


def _in_order(weights: FloatArray, structure: NarxStructure) -> FloatArray:
    """Weights by neuron (R, hidden, n_features + 3), neurons by their positive output weights."""
    n, hidden = len(weights), structure.hidden
    output = weights[:, structure.w2]
    by_neuron = np.concatenate(
        [
            weights[:, structure.w1].reshape(n, hidden, structure.n_features),
            weights[:, structure.b1, None],
            output[..., None],
        ],
        axis=2,
    )
    by_neuron *= np.where(output < 0, -1.0, 1.0)[..., None]
    order = np.argsort(by_neuron[..., -1], axis=1)
    by_neuron = np.take_along_axis(by_neuron, order[..., None], axis=1)
    last = np.broadcast_to(weights[:, structure.b2, None, None], (n, hidden, 1))
    return np.concatenate([by_neuron, last], axis=2)
