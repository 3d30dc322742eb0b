"""Training sequences: parts of a recording without gaps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from narx.errors import UserError
from narx.kinematics.rate_unit import warn_of_degrees
from narx.method import SegmentSignals
from narx.missing import finite_rows
from narx.settings import Positive, Samples, SamplesLike, check_fields, checked
from narx.types import BoolArray, FloatArray


@dataclass(frozen=True)
class TrainingSequence:
    """A part of one segment's recording without gaps, with target angles.

    Parameters
    ----------
    name : str
        Trial and segment, for messages.
    signals : SegmentSignals
        Calibrated gyroscope.
    target_rad : ndarray, shape (N, 3)
        The teacher's angles, order of `narx.kinematics.segment_angles.AXES`; NaN where missing.
    weight : float
        Weight of its squared errors.

    Raises
    ------
    UserError
        If a field has another type.
    """

    name: str
    signals: SegmentSignals
    target_rad: Samples
    weight: Positive = 1.0

    def __post_init__(self) -> None:
        check_fields(self, "TrainingSequence")

    @property
    def duration_s(self) -> float:
        """Length in s."""
        return self.signals.n_samples * self.signals.interval_s


@checked
def from_arrays(
    rates_rad_s: SamplesLike,
    angles_rad: SamplesLike,
    sampling_rate_hz: float,
    name: str = "arrays",
    weight: Positive = 1.0,
) -> list[TrainingSequence]:
    """Create training sequences from arrays.

    Parameters
    ----------
    rates_rad_s : array_like, shape (N, 3)
        Gyroscope about the sagittal, frontal and transverse axis, rad/s; NaN where missing.
    angles_rad : array_like, shape (N, 3)
        Angles to learn, rad, same axes and samples; NaN where missing.
    sampling_rate_hz : float
        Rate of both, Hz.
    name : str
        Name for messages and the network's history.
    weight : float
        Weight of the squared errors.

    Returns
    -------
    list of TrainingSequence
        One for each part of at least 2 s without a gap in the rates.

    Raises
    ------
    UserError
        If a shape or the sampling rate is wrong, a value is infinite, or no stretch is long
        enough.

    Warns
    -----
    UserWarning
        If the rates are too fast for a leg, as in degrees per second.
    """
    rates, angles = np.asarray(rates_rad_s), np.asarray(angles_rad)
    for what, values in (("rates_rad_s", rates), ("angles_rad", angles)):
        if values.ndim != 2 or values.shape[1] != 3 or len(values) != len(rates):
            raise UserError(
                f"{name}: {what} has shape {values.shape}, expected (N, 3) with the same N for "
                "rates and angles"
            )
        if np.isinf(values).any():
            row = int(np.flatnonzero(np.isinf(values).any(axis=1))[0])
            raise UserError(f"{name}: {what} is infinite at sample {row}")
    if not 0 < sampling_rate_hz < np.inf:
        raise UserError(f"{name}: sampling_rate_hz is {sampling_rate_hz}, expected above 0 Hz")
    warn_of_degrees(rates, f"{name}: rates_rad_s")
    signals = SegmentSignals(name, float(sampling_rate_hz), rates, np.full_like(rates, np.nan))
    sequences = contiguous(name, signals, angles, np.ones(len(rates), dtype=bool), weight)
    if not sequences:
        raise UserError(f"{name}: no part of 2 s without a gap in rates_rad_s")
    return sequences


def contiguous(
    name: str,
    signals: SegmentSignals,
    target_rad: FloatArray,
    keep: BoolArray,
    weight: float = 1.0,
    shortest_s: float = 2.0,
) -> list[TrainingSequence]:
    """Split a recording at its gaps, so that lags never cross one.

    Parameters
    ----------
    name : str
        Trial and segment.
    signals : SegmentSignals
        Signals of the whole recording.
    target_rad : ndarray, shape (N, 3)
        The teacher's angles.
    keep : ndarray of bool, shape (N,)
        Samples that may be trained on.
    weight : float
        Of the squared errors.
    shortest_s : float
        Shorter parts are left out, s.

    Returns
    -------
    list of TrainingSequence
        Sequences in time order.
    """
    usable = keep & finite_rows(signals.axis_rates_rad_s)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], usable.astype(np.int8), [0]])))
    return [
        TrainingSequence(name, signals.select(slice(start, stop)), target_rad[start:stop], weight)
        for start, stop in zip(edges[::2], edges[1::2], strict=True)
        if (stop - start) * signals.interval_s >= shortest_s
    ]


def hold_back(
    sequences: Sequence[TrainingSequence], fraction: float
) -> tuple[list[TrainingSequence], list[TrainingSequence]]:
    """Hold out the end of every sequence to choose among restarts.

    Parameters
    ----------
    sequences : sequence of TrainingSequence
        All sequences available for training.
    fraction : float
        Share of each sequence that is held out, in [0, 1).

    Returns
    -------
    training, validation : list of TrainingSequence
        No sample is in both. With a fraction of zero, the training data are used for both.
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
