"""What a network is trained on: stretches without gaps, side by side in a batch."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from torch import Tensor

from narx.errors import UserError
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.types import BoolArray, FloatArray


@dataclass(frozen=True)
class TrainingSequence:
    """A stretch of one segment without gaps, with the angles to learn.

    Parameters
    ----------
    name : str
        Trial and segment, for messages.
    signals : SegmentSignals
        Calibrated gyroscope.
    target_rad : ndarray, shape (N, 3)
        The teacher's angles, order of `narx.kinematics.segment_angles.AXES`; NaN where it has none.
    weight : float
        Of its squared errors.
    """

    name: str
    signals: SegmentSignals
    target_rad: FloatArray
    weight: float = 1.0

    @property
    def duration_s(self) -> float:
        """Length in s."""
        return self.signals.n_samples * self.signals.interval_s


def contiguous(
    name: str,
    signals: SegmentSignals,
    target_rad: FloatArray,
    keep: BoolArray,
    weight: float = 1.0,
    shortest_s: float = 2.0,
) -> list[TrainingSequence]:
    """Cut a recording at its gaps, so that delays never cross one.

    Parameters
    ----------
    name : str
        Trial and segment.
    signals : SegmentSignals
        Of the whole recording.
    target_rad : ndarray, shape (N, 3)
        The teacher's angles.
    keep : ndarray of bool, shape (N,)
        Samples that may be trained on.
    weight : float
        Of the squared errors.
    shortest_s : float
        Stretches below this are left out, s.

    Returns
    -------
    list of TrainingSequence
        In time order.
    """
    usable = keep & np.isfinite(signals.axis_rates_rad_s).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], usable.astype(np.int8), [0]])))
    return [
        TrainingSequence(name, signals.select(slice(start, stop)), target_rad[start:stop], weight)
        for start, stop in zip(edges[::2], edges[1::2], strict=True)
        if (stop - start) * signals.interval_s >= shortest_s
    ]


def hold_back(
    sequences: Sequence[TrainingSequence], fraction: float
) -> tuple[list[TrainingSequence], list[TrainingSequence]]:
    """Keep the end of every sequence for choosing among restarts.

    Parameters
    ----------
    sequences : sequence of TrainingSequence
        All that may be trained on.
    fraction : float
        Share of each sequence that is held back, in [0, 1).

    Returns
    -------
    training, validation : list of TrainingSequence
        No sample is in both. With a fraction of zero the validation is the training itself.
    """
    if fraction == 0:
        return list(sequences), list(sequences)
    training: list[TrainingSequence] = []
    validation: list[TrainingSequence] = []
    for sequence in sequences:
        cut = round((1.0 - fraction) * sequence.signals.n_samples)
        for part, target in ((slice(None, cut), training), (slice(cut, None), validation)):
            target.append(
                TrainingSequence(
                    sequence.name,
                    sequence.signals.select(part),
                    sequence.target_rad[part],
                    sequence.weight,
                )
            )
    return training, validation


@dataclass(frozen=True)
class Batch:
    """Sequences side by side, padded at the end, with what a rollout of them needs.

    Parameters
    ----------
    rates_rad_s : Tensor, shape (B, N, 3)
        Gyroscope, zero after a sequence's end.
    targets_rad : Tensor, shape (B, N, 3)
        Angles wanted, including the posture; NaN where none (padding included).
    state : Tensor, shape (B, 3, n_state)
        Normalised state before the first sample.
    posture_rad : Tensor, shape (B, 3)
        Angle about which the network works.
    weight : Tensor, shape (B,)
        Of the squared errors.
    """

    rates_rad_s: Tensor
    targets_rad: Tensor
    state: Tensor
    posture_rad: Tensor
    weight: Tensor


InitialState = Literal["teacher", "zero"]


def batch(sequences: Sequence[TrainingSequence], model: Narx, initial_state: InitialState) -> Batch:
    """Put sequences side by side for a network.

    Parameters
    ----------
    sequences : sequence of TrainingSequence
        Of the network's sampling rate.
    model : Narx
        Gives the scales of the state.
    initial_state : {"teacher", "zero"}
        Start from the teacher's first angles, about the mean posture; or from zero about zero
        (Tham et al., II-B3).

    Returns
    -------
    Batch
        float64.

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
            # one step back along the first rate: there is no sample before the first
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
