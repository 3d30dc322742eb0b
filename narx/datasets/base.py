"""Common base of sources of trials: an index that can be filtered, and lazy loading."""

import copy
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import ClassVar

import pandas as pd

from narx.calibration.calibrate import CalibratedSegment, Mode, calibrate
from narx.errors import UserError
from narx.recordings.trial import Trial

Name = str | int
INDEX_COLUMNS = ("subject", "condition", "trial")


class TrialSource(ABC):
    """A set of trials that are read (or generated) one at a time.

    A subclass lists its trials in `_list_trials` and reads one in `_load`. Trials are read on
    demand and not stored: a loop over a source has one trial in memory at a time.
    """

    name: ClassVar[str]

    _listed: pd.DataFrame | None = None

    @abstractmethod
    def _list_trials(self) -> pd.DataFrame:
        """List every trial: columns subject, condition, trial, then those of the source."""

    @abstractmethod
    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        """Read one trial that is in the index."""

    @classmethod
    def files(cls, root: Path) -> list[Path]:
        """List what the trials may be read from.

        Parameters
        ----------
        root : pathlib.Path
            The source's folder.

        Returns
        -------
        list of pathlib.Path
            Everything below it but hidden files, sorted.
        """
        return sorted(root.rglob("[!.]*"))

    def index(self) -> pd.DataFrame:
        """List the selected trials.

        Returns
        -------
        pandas.DataFrame
            One row per trial; columns ``subject``, ``condition``, ``trial`` (strings, as named by
            the source) and further ones of the source, such as ``device``, or ``has_reference``
            and ``duration_s`` where they are known without reading the trials.

        Raises
        ------
        UserError
            If the recordings are not found.
        """
        if self._listed is None:
            self._listed = self._list_trials().reset_index(drop=True)
        return self._listed.copy()

    def select(
        self,
        subject: Name | Iterable[Name] | None = None,
        condition: Name | Iterable[Name] | None = None,
        trial: Name | Iterable[Name] | None = None,
    ) -> "TrialSource":
        """Return the same source with fewer trials.

        Parameters
        ----------
        subject, condition, trial : str or int, or iterable of these, optional
            Names to keep; None keeps all.

        Returns
        -------
        TrialSource
            Trials that match every given name, in the order of the index.

        Raises
        ------
        UserError
            If a name is not in the index, or no trial has this combination.
        """
        rows = self.index()
        for column, wanted in zip(INDEX_COLUMNS, (subject, condition, trial), strict=True):
            if wanted is None:
                continue
            # a number on the command line is converted to a name
            several = [wanted] if isinstance(wanted, str | int) else wanted
            names = [str(name) for name in several]
            self._check_known(column, names)
            rows = rows[rows[column].isin(names)]
        if rows.empty:
            raise UserError(
                f"{self.name}: no trial with subject={subject}, condition={condition}, "
                f"trial={trial} together"
            )
        selected = copy.copy(self)
        selected._listed = rows.reset_index(drop=True)
        return selected

    def load(self, subject: str, condition: str, trial: str) -> Trial:
        """Read one trial.

        Parameters
        ----------
        subject, condition, trial : str
            Names as in the index.

        Returns
        -------
        Trial
            The recording, on a uniform clock.

        Raises
        ------
        UserError
            If there is no such trial.
        RecordingError
            If a file is damaged or incomplete.
        """
        self.select(subject, condition, trial)
        # a name may be given as a number, as in `select`
        return self._load(str(subject), str(condition), str(trial))

    def load_calibrated(
        self, subject: str, condition: str, trial: str, mode: Mode = "auto"
    ) -> tuple[Trial, dict[str, CalibratedSegment]]:
        """Read one trial and calibrate its segments.

        Parameters
        ----------
        subject, condition, trial : str
            Names as in the index.
        mode : {"auto", "leg", "knee", "functional", "walking", "sensor"}
            As `narx.calibration.calibrate`.

        Returns
        -------
        trial : Trial
            As `load`.
        segments : dict of str to CalibratedSegment
            By segment name.

        Raises
        ------
        UserError
            As `load` and `narx.calibration.calibrate`.
        """
        self.select(subject, condition, trial)
        return self._load_calibrated(str(subject), str(condition), str(trial), mode)

    def _load_calibrated(
        self, subject: str, condition: str, trial: str, mode: Mode
    ) -> tuple[Trial, dict[str, CalibratedSegment]]:
        loaded = self._load(subject, condition, trial)
        return loaded, calibrate(loaded, mode)

    def __len__(self) -> int:
        return len(self.index())

    def __iter__(self) -> Iterator[Trial]:
        for row in self.index().itertuples(index=False):
            yield self._load(str(row.subject), str(row.condition), str(row.trial))

    def _check_known(self, column: str, names: list[str]) -> None:
        known = self.index()[column].astype(str).unique()
        for name in names:
            if name not in known:
                raise UserError(
                    f"{self.name}: no {column} '{name}'; known are {', '.join(sorted(known))}"
                )
