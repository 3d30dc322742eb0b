"""Padded batches of training sequences for a closed-loop rollout."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import torch
from torch import Tensor

from narx.errors import UserError
from narx.network.model import Narx
from narx.windows.sequences import TrainingSequence


@dataclass(frozen=True)
class Batch:
    """A batch of sequences, padded at the end, with states and targets for a rollout.

    Parameters
    ----------
    rates_rad_s : Tensor, shape (B, N, 3)
        Gyroscope, zero after a sequence's end.
    targets_rad : Tensor, shape (B, N, 3)
        Target angles, including the posture; NaN where missing (padding included).
    state : Tensor, shape (B, 3, n_state)
        Normalised state before the first sample.
    posture_rad : Tensor, shape (B, 3)
        Angle at a network output of zero.
    weight : Tensor, shape (B,)
        Weight of the squared errors of each sequence.
    """

    rates_rad_s: Tensor
    targets_rad: Tensor
    state: Tensor
    posture_rad: Tensor
    weight: Tensor


InitialState = Literal["teacher", "zero"]


def batch(sequences: Sequence[TrainingSequence], model: Narx, initial_state: InitialState) -> Batch:
    """Arrange sequences in parallel for a network.

    Parameters
    ----------
    sequences : sequence of TrainingSequence
        Sequences with the network's sampling rate.
    model : Narx
        Network whose scales apply to the state.
    initial_state : {"teacher", "zero"}
        Start from the teacher's first angles about the mean posture, or from zero angles about a
        posture of zero (Tham et al., II-B3).

    Returns
    -------
    Batch
        Batch in float64.

    Raises
    ------
    UserError
        If a sampling rate differs from the network's.
    """
    for sequence in sequences:
        if not math.isclose(
            sequence.signals.sampling_rate_hz, model.sampling_rate_hz, rel_tol=1e-6
        ):
            raise UserError(
                f"training: {sequence.name} is sampled at {sequence.signals.sampling_rate_hz:g} "
                f"Hz, the network runs at {model.sampling_rate_hz:g} Hz; give every source the "
                "same sampling_rate_hz"
            )
    length = max(sequence.signals.n_samples for sequence in sequences)
    rates = torch.zeros(len(sequences), length, 3, dtype=torch.float64)
    targets = torch.full_like(rates, math.nan)
    posture = torch.zeros(len(sequences), 3, dtype=torch.float64)
    angles, previous, first_rates = (torch.zeros_like(posture) for _ in range(3))
    for row, sequence in enumerate(sequences):
        n = sequence.signals.n_samples
        rates[row, :n] = torch.from_numpy(sequence.signals.axis_rates_rad_s)
        target = torch.from_numpy(sequence.target_rad)
        targets[row, :n] = target
        if initial_state == "teacher":
            posture[row] = torch.nan_to_num(target.nanmean(dim=0))
            rate = rates[row, 0]
            # there is no sample before the first: extrapolate one step back along the first rate
            angles[row] = torch.nan_to_num(target[0] - posture[row]) - rate / model.sampling_rate_hz
            previous[row] = angles[row] - rate / model.sampling_rate_hz
            first_rates[row] = rate
    return Batch(
        rates,
        targets,
        model.initial_state(angles, previous, first_rates)
        if initial_state == "teacher"
        else torch.zeros(len(sequences), 3, model.structure.n_state, dtype=torch.float64),
        posture,
        torch.tensor([sequence.weight for sequence in sequences], dtype=torch.float64),
    )
