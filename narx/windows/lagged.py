"""Lagged windows of recorded signals: the network's inputs for one-step-ahead prediction."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor
from torch.utils.data import Dataset

from narx.network.cell import coupled_rates
from narx.network.model import Narx
from narx.settings import Samples, checked
from narx.types import FloatArray
from narx.windows.sequences import TrainingSequence


class LaggedWindows(Dataset[tuple[Tensor, Tensor]]):
    """One-step-ahead pairs (v_k, v_{k-1}, p_{k-1}, p_{k-2}) -> p_k (Tham et al., Fig. 4).

    Lags never cross the border of a sequence or a gap: a pair exists only if all its values were
    measured. The data set can be passed to a `torch.utils.data.DataLoader`, and is used in the
    open-loop stage of every optimiser.

    Parameters
    ----------
    inputs : sequence of ndarray, each of shape (N_i,) or (N_i, n_inputs)
        Angular rate, one array per sequence, in the unit of training; NaN
        where missing.
    outputs : sequence of ndarray, each of shape (N_i,)
        Angle, likewise.
    input_lags : int
        Number of samples of the input: v_k ... v_{k-input_lags+1}.
    output_lags : int
        Number of past outputs: p_{k-1} ... p_{k-output_lags}.
    weights : sequence of float, optional
        Weights of the squared errors of each sequence; 1 if not given.

    Attributes
    ----------
    features : Tensor, shape (M, n_inputs * input_lags + output_lags)
        Newest first: all inputs of a sample together, then the outputs.
    targets : Tensor, shape (M,)
        Target outputs.
    weights : Tensor, shape (M,)
        Weight of the squared error of each pair; not part of a pair.

    Raises
    ------
    UserError
        If an argument has another type.
    ValueError
        If the lags are not positive, or inputs, outputs and weights do not pair up.
    """

    features: Tensor
    targets: Tensor
    weights: Tensor

    @checked
    def __init__(
        self,
        inputs: Sequence[Samples],
        outputs: Sequence[Samples],
        input_lags: int = 2,
        output_lags: int = 2,
        weights: Sequence[float] | None = None,
    ) -> None:
        if input_lags < 1 or output_lags < 1:
            raise ValueError(f"lags must be positive, got {input_lags} and {output_lags}")
        weights = [1.0] * len(inputs) if weights is None else weights
        if not len(inputs) == len(outputs) == len(weights):
            raise ValueError(
                f"{len(inputs)} input sequences, {len(outputs)} output sequences and "
                f"{len(weights)} weights do not pair up"
            )
        n_inputs = np.shape(inputs[0])[1] if len(inputs) and np.ndim(inputs[0]) > 1 else 1
        first = max(input_lags - 1, output_lags)
        parts = [np.empty((n_inputs * input_lags + output_lags + 1, 0))]
        for rate, angle in zip(inputs, outputs, strict=True):
            rate = np.asarray(rate, dtype=float)
            rate = rate[:, None] if rate.ndim == 1 else rate
            angle = np.asarray(angle, dtype=float)
            if angle.shape != (len(rate),):
                raise ValueError(f"output has shape {angle.shape}, expected ({len(rate)},)")
            n = max(len(rate) - first, 0)
            rows = [rate[first - lag :][:n].T for lag in range(input_lags)]
            rows += [angle[None, first - lag :][:, :n] for lag in range(1, output_lags + 1)]
            pairs = np.concatenate([*rows, angle[None, first:][:, :n]])
            parts.append(pairs[:, np.isfinite(pairs).all(axis=0)])
        # one row per feature, the layout of the compiled fit; `features` is a transposed view
        pairs = np.concatenate(parts, axis=1)
        self.features = torch.from_numpy(pairs[:-1]).T
        self.targets = torch.from_numpy(pairs[-1])
        counts = [part.shape[1] for part in parts[1:]]
        self.weights = torch.from_numpy(np.repeat(np.asarray(weights, dtype=float), counts))

    @classmethod
    def of_sequences(
        cls,
        model: Narx,
        sequences: Sequence[TrainingSequence],
        axis_weights: Sequence[float] = (1.0, 1.0, 1.0),
    ) -> "LaggedWindows":
        """Create the windows of training sequences of one or many trials for a network.

        Parameters
        ----------
        model : Narx
            Gives lags, scales and whether the axes are coupled.
        sequences : sequence of TrainingSequence
            Sequences; the posture of each is its mean angle.
        axis_weights : sequence of three floats
            Of the squared errors of each axis; an axis of zero is left out.

        Returns
        -------
        LaggedWindows
            Normalised, all axes of all sequences one after another.
        """
        return cls.of_arrays(
            model,
            [sequence.signals.axis_rates_rad_s for sequence in sequences],
            [sequence.target_rad for sequence in sequences],
            [_mean(sequence.target_rad) for sequence in sequences],
            [sequence.weight for sequence in sequences],
            axis_weights,
        )

    @classmethod
    def of_arrays(
        cls,
        model: Narx,
        rates_rad_s: Sequence[FloatArray],
        angles_rad: Sequence[FloatArray],
        postures_rad: Sequence[FloatArray],
        weights: Sequence[float],
        axis_weights: Sequence[float],
    ) -> "LaggedWindows":
        """Create the windows of gyroscope signals and angles for a network.

        Coupled axes use the tilt of the angles at the same sample as the rate.

        Parameters
        ----------
        model : Narx
            Gives lags, scales and whether the axes are coupled.
        rates_rad_s, angles_rad : sequence of ndarray, each of shape (N_i, 3)
            Gyroscope and angles of each sequence; NaN where missing.
        postures_rad : sequence of ndarray, each of shape (3,)
            Posture of the network, for each sequence.
        weights : sequence of float
            Of the squared errors of each sequence.
        axis_weights : sequence of three floats
            Of the squared errors of each axis; an axis of zero is left out.

        Returns
        -------
        LaggedWindows
            Normalised, all axes of all sequences one after another.
        """
        scaled = model.normalisation
        inputs: list[FloatArray] = []
        outputs: list[FloatArray] = []
        for rates, angles, posture in zip(rates_rad_s, angles_rad, postures_rad, strict=True):
            if model.coupled:
                tilted = coupled_rates(torch.from_numpy(rates), torch.from_numpy(angles))
                rates = tilted.numpy()
            inputs += list(((rates - scaled.rate_offset_rad_s) / scaled.rate_scale_rad_s).T)
            deviation = angles - posture - scaled.angle_offset_rad
            outputs += list((deviation / scaled.angle_scale_rad).T)
        both = np.outer(weights, axis_weights).ravel()
        kept = np.flatnonzero(both > 0)
        return cls(
            [inputs[i] for i in kept],
            [outputs[i] for i in kept],
            model.structure.input_lags,
            model.structure.output_lags,
            both[kept].tolist(),
        )

    def __len__(self) -> int:
        return len(self.targets)

    def __getitem__(self, index: int) -> tuple[Tensor, Tensor]:
        return self.features[index], self.targets[index]


def _mean(angles_rad: FloatArray) -> FloatArray:
    there = np.isfinite(angles_rad)
    total = np.where(there, angles_rad, 0.0).sum(axis=0)
    return np.divide(total, there.sum(axis=0), out=np.zeros(3), where=there.any(axis=0))
