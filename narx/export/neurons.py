"""A network in as few operations as it needs: scales folded into the weights, equal neurons one."""

import numpy as np

from narx.inference.checkpoint import Checkpoint
from narx.types import FloatArray


def physical_weights(
    checkpoint: Checkpoint,
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Fold the normalisation into the weights.

    Parameters
    ----------
    checkpoint : Checkpoint
        A trained network.

    Returns
    -------
    w1 : ndarray, shape (hidden, features)
        For rates in rad/s and deviations in rad.
    b1 : ndarray, shape (hidden,)
        Biases.
    w2 : ndarray, shape (hidden,)
        To a deviation in rad.
    b2 : float
        Its bias, rad.
    """
    structure, scaled = checkpoint.model.structure, checkpoint.model.normalisation
    weights = checkpoint.model.weights.detach().numpy()
    w1 = weights[structure.w1].reshape(structure.hidden, structure.n_features).copy()
    b1, w2 = weights[structure.b1].copy(), weights[structure.w2] * scaled.angle_scale_rad
    n_rates = structure.n_input_features
    for columns, offset, scale in (
        (slice(0, n_rates), scaled.rate_offset_rad_s, scaled.rate_scale_rad_s),
        (slice(n_rates, None), scaled.angle_offset_rad, scaled.angle_scale_rad),
    ):
        w1[:, columns] /= scale
        b1 -= offset * w1[:, columns].sum(axis=1)
    b2 = weights[structure.b2] * scaled.angle_scale_rad + scaled.angle_offset_rad
    return w1, b1, w2, float(b2)


def merged_neurons(
    w1: FloatArray, b1: FloatArray, w2: FloatArray, b2: float, same: float
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Make one neuron of those that are the same.

    Parameters
    ----------
    w1, b1, w2, b2 : ndarray and float
        From `physical_weights`.
    same : float
        Neurons whose weights differ by less than this share are one: what they differ by cancels
        to first order, since the first layer is averaged with the weights of the second.

    Returns
    -------
    w1, b1, w2, b2 : ndarray and float
        Of a network that answers the same.
    """
    layer = np.column_stack([w1, b1])
    groups: list[list[int]] = []
    for j, neuron in enumerate(layer):
        for group in groups:
            first = layer[group[0]]
            close = np.abs(neuron - first) <= same * np.abs(first) + 1e-12 * np.abs(first).max()
            if close.all() and w2[group[0]] * w2[j] > 0:
                group.append(j)
                break
        else:
            groups.append([j])
    merged = np.stack([np.average(layer[group], axis=0, weights=w2[group]) for group in groups])
    return merged[:, :-1], merged[:, -1], np.array([w2[group].sum() for group in groups]), b2
