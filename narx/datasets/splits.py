"""Division into training and test: test parts are held out from training."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from narx.calibration.calibrate import CalibratedSegment, Mode
from narx.datasets.base import TrialSource
from narx.errors import UserError
from narx.recordings.trial import Trial
from narx.settings import Name, PositiveSeconds, Seconds, Seed, checked


@dataclass(frozen=True)
class TrialPart:
    """A part of one trial.

    Parameters
    ----------
    source, subject, condition, trial : str
        Name of the source and index columns of the trial.
    start_s, stop_s : float
        Part of the trial in s from its first sample.
    """

    source: str
    subject: str
    condition: str
    trial: str
    start_s: float = 0.0
    stop_s: float = float("inf")

    @property
    def key(self) -> tuple[str, str, str, str]:
        """The trial's names, without the part."""
        return self.source, self.subject, self.condition, self.trial

    def whole(self) -> "TrialPart":
        """Widen the part to its trial.

        Returns
        -------
        TrialPart
            From the first sample to the last.
        """
        return TrialPart(*self.key)


@dataclass(frozen=True)
class Fold:
    """One training and the parts it is tested on.

    Parameters
    ----------
    name : str
        Name of the held-out part, or of the choice of the training part.
    training, test : tuple of TrialPart
        Without a training part, a trained network is used: a checkpoint, or the shipped one.
    validation : tuple of TrialPart
        Parts to choose among restarts; if empty, the end of every training part is held out.
    """

    name: str
    training: tuple[TrialPart, ...]
    test: tuple[TrialPart, ...]
    validation: tuple[TrialPart, ...] = ()


def _parts(
    rows: pd.DataFrame, start_s: float = 0.0, stop_s: float = float("inf")
) -> Iterator[TrialPart]:
    for row in rows.itertuples(index=False):
        yield TrialPart(
            str(row.source), str(row.subject), str(row.condition), str(row.trial), start_s, stop_s
        )


@checked
def within_trial(
    index: pd.DataFrame, *, training_s: PositiveSeconds = 30.0, skip_s: Seconds = 5.0
) -> Iterator[Fold]:
    """Train on the beginning of each trial, test on the rest of the same trial.

    Parameters
    ----------
    index : pandas.DataFrame
        Trials with columns source, subject, condition, trial.
    training_s : float
        Length of the training part in s.
    skip_s : float
        Time before the training part in s.

    Yields
    ------
    Fold
        One per trial.
    """
    for position in range(len(index)):
        rows = index.iloc[[position]]
        (training,) = _parts(rows, skip_s, skip_s + training_s)
        (test,) = _parts(rows, skip_s + training_s)
        yield Fold("/".join(training.key), (training,), (test,))


@checked
def leave_one_out(index: pd.DataFrame, *, column: Name = "subject") -> Iterator[Fold]:
    """Test on each subject (or device, or condition) with a network trained on all others.

    Parameters
    ----------
    index : pandas.DataFrame
        Trials with columns source, subject, condition, trial and `column`.
    column : str
        Column of the index whose values are held out one by one.

    Yields
    ------
    Fold
        One per value of the column.

    Raises
    ------
    UserError
        If the sources have no such column, or it has fewer than two values.
    """
    if column not in index or index[column].isna().any():
        known = ", ".join(index.columns)
        raise UserError(f"split: the data has no column '{column}' to leave out; it has {known}")
    values = list(dict.fromkeys(index[column]))
    if len(values) < 2:
        raise UserError(
            f"split: leaving one {column} out needs at least two, found only '{values[0]}'; "
            "use split=within_trial"
        )
    for value in values:
        left_out = index[column] == value
        yield Fold(
            f"without_{column}_{value}",
            tuple(_parts(index[~left_out])),
            tuple(_parts(index[left_out])),
        )


@checked
def one_window(
    index: pd.DataFrame,
    *,
    condition: Name | None = None,
    window_s: PositiveSeconds = 10.0,
    earliest_s: Seconds = 20.0,
    latest_s: Seconds = 250.0,
    validation_s: Seconds = 20.0,
    subject: Name | None = None,
    seed: Seed = 0,
) -> Iterator[Fold]:
    """Train on one short window of one random subject, test on every trial (Tham et al., II-B2).

    Parameters
    ----------
    index : pandas.DataFrame
        Trials with columns source, subject, condition, trial.
    condition : str, optional
        Condition to train on; None draws from all trials.
    window_s : float
        Length of the window in s.
    earliest_s, latest_s : float
        Range in s in which the window starts; in a trial whose ``duration_s`` is in the index, not
        so late that window or validation would not fit.
    validation_s : float
        Length of the part after the window used to choose among restarts, s; with 0, the end of
        the window is used (`training.held_back`).
    subject : str, optional
        Subject to train on; None draws one.
    seed : int
        Seed for the choice of subject and window.

    Yields
    ------
    Fold
        One fold. The test parts include the training window, as in the paper.

    Raises
    ------
    UserError
        If no trial has that subject and condition, or the window does not fit into it.
    """
    if earliest_s > latest_s:
        raise UserError(
            f"split: earliest_s is {earliest_s:g} and latest_s {latest_s:g}, expected the earliest "
            "not after the latest"
        )
    rng = np.random.default_rng(seed)
    rows = index
    for column, wanted in (("condition", condition), ("subject", subject)):
        if wanted is not None:
            rows = rows[rows[column] == wanted]
    if rows.empty:
        raise UserError(f"split: no trial with subject={subject}, condition={condition}")
    chosen = rows.iloc[[int(rng.integers(len(rows)))]]
    duration_s = float(chosen["duration_s"].iloc[0]) if "duration_s" in chosen else np.nan
    if not np.isnan(duration_s):
        latest_s = min(latest_s, duration_s - window_s - validation_s)
    if latest_s < earliest_s:
        (part,) = _parts(chosen)
        raise UserError(
            f"split: {'/'.join(part.key)} lasts {duration_s:g} s, expected earliest_s "
            f"({earliest_s:g}), window_s ({window_s:g}) and validation_s ({validation_s:g}) "
            "of split=one_window to fit into it"
        )
    start_s = float(rng.uniform(earliest_s, latest_s))
    (training,) = _parts(chosen, start_s, start_s + window_s)
    (validation,) = _parts(chosen, start_s + window_s, start_s + window_s + validation_s)
    yield Fold(
        f"{training.subject}_{training.condition}_{start_s:.0f}s",
        (training,),
        tuple(_parts(index)),
        (validation,) if validation_s > 0 else (),
    )


def everything(index: pd.DataFrame) -> Iterator[Fold]:
    """Train on all trials without a test, for a network to be used on other data.

    Parameters
    ----------
    index : pandas.DataFrame
        Trials with columns source, subject, condition, trial.

    Yields
    ------
    Fold
        One.
    """
    yield Fold("everything", tuple(_parts(index)), ())


def pretrained(index: pd.DataFrame) -> Iterator[Fold]:
    """Test a network that is already trained on all trials.

    Parameters
    ----------
    index : pandas.DataFrame
        Trials with columns source, subject, condition, trial.

    Yields
    ------
    Fold
        One, without a training part.
    """
    yield Fold("pretrained", (), tuple(_parts(index)))


@checked
def automatic(index: pd.DataFrame, *, testing: bool = True, seed: Seed = 0) -> Iterator[Fold]:
    """Choose a split appropriate for the data.

    Parameters
    ----------
    index : pandas.DataFrame
        Trials with columns source, subject, condition, trial.
    testing : bool
        Whether the folds are to be tested.
    seed : int
        Of the window's draw.

    Yields
    ------
    Fold
        The paper's window on simulated gait. Otherwise: everything for training only; for tests,
        one subject left out if there are several, or an already trained network if not.
    """
    if set(index["source"]) == {"simulated_gait"}:
        normal = "normal" if (index["condition"] == "normal").any() else None
        yield from one_window(index, condition=normal, seed=seed)
    elif not testing:
        yield from everything(index)
    elif index["subject"].nunique() > 1:
        yield from leave_one_out(index)
    else:
        yield from pretrained(index)


def load_calibrated(
    sources: Mapping[str, TrialSource], part: TrialPart, mode: Mode
) -> tuple[Trial, dict[str, CalibratedSegment]]:
    """Load the trial that a part belongs to, and calibrate it.

    Parameters
    ----------
    sources : mapping of str to TrialSource
        By source name.
    part : TrialPart
        Names the trial.
    mode : {"auto", "leg", "knee", "functional", "walking", "sensor"}
        As `narx.calibration.calibrate`.

    Returns
    -------
    trial : Trial
        The whole trial.
    segments : dict of str to CalibratedSegment
        By segment name.
    """
    return sources[part.source].load_calibrated(part.subject, part.condition, part.trial, mode)
