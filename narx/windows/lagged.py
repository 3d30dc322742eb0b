"""Lagged windows of recorded signals: what the network sees one step ahead."""

from collections.abc import Sequence

import numpy as np
import torch
from numpy.lib.stride_tricks import sliding_window_view
from torch import Tensor
from torch.utils.data import Dataset

from narx.types import FloatArray


class LaggedWindows(Dataset[tuple[Tensor, Tensor]]):
    """One-step-ahead pairs (v_k, v_{k-1}, p_{k-1}, p_{k-2}) -> p_k (Tham et al., Fig. 4).

    Lags never cross the border of a sequence or a gap: a pair exists only where every value in
    it was measured.

    Parameters
    ----------
    inputs : sequence of ndarray, each of shape (N_i,) or (N_i, n_inputs)
        Angular rate, one array a sequence, in whatever unit the network is trained in; NaN
        where missing.
    outputs : sequence of ndarray, each of shape (N_i,)
        Angle, likewise.
    input_lags : int
        Number of samples of the input: v_k ... v_{k-input_lags+1}.
    output_lags : int
        Number of past outputs: p_{k-1} ... p_{k-output_lags}.

    Raises
    ------
    ValueError
        If the lags are not positive, or inputs and outputs do not pair up.
    """

    def __init__(
        self,
        inputs: Sequence[FloatArray],
        outputs: Sequence[FloatArray],
        input_lags: int = 2,
        output_lags: int = 2,
    ) -> None:
        if input_lags < 1 or output_lags < 1:
            raise ValueError(f"lags must be positive, got {input_lags} and {output_lags}")
        if len(inputs) != len(outputs):
            raise ValueError(f"{len(inputs)} input sequences, but {len(outputs)} output sequences")
        first = max(input_lags - 1, output_lags)
        features, targets = [], []
        for rate, angle in zip(inputs, outputs, strict=True):
            rate = np.asarray(rate, dtype=float)
            rate = rate[:, None] if rate.ndim == 1 else rate
            angle = np.asarray(angle, dtype=float)
            if angle.shape != (len(rate),):
                raise ValueError(f"output has shape {angle.shape}, expected ({len(rate)},)")
            if len(rate) <= first:
                continue
            # windows run oldest to newest; the network's order is newest first
            rates = sliding_window_view(rate[first - input_lags + 1 :], input_lags, axis=0)
            angles = sliding_window_view(angle[first - output_lags : -1], output_lags)
            rates_newest_first = rates[:, :, ::-1].transpose(0, 2, 1).reshape(len(rates), -1)
            pairs = np.column_stack([rates_newest_first, angles[:, ::-1], angle[first:]])
            pairs = pairs[np.isfinite(pairs).all(axis=1)]
            features.append(pairs[:, :-1])
            targets.append(pairs[:, -1])
        n_features = input_lags * (np.shape(inputs[0])[1] if np.ndim(inputs[0]) > 1 else 1)
        n_features += output_lags
        empty = np.empty((0, n_features)), np.empty(0)
        self.features = torch.from_numpy(np.concatenate([*features, empty[0]]))
        self.targets = torch.from_numpy(np.concatenate([*targets, empty[1]]))

    def __len__(self) -> int:
        return len(self.targets)

    def __getitem__(self, position: int) -> tuple[Tensor, Tensor]:
        return self.features[position], self.targets[position]
