"""The common interface of all reports: observe every trial, then report the results."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

from omegaconf import DictConfig

from narx.calibration.calibrate import CalibratedSegment
from narx.evaluation.comparison import Evaluated
from narx.evaluation.trial import Refusal
from narx.experiments.gathered import Gathered
from narx.experiments.tables.table import Table
from narx.method import OrientationMethod
from narx.recordings.trial import Trial

if TYPE_CHECKING:  # commands without figures do not import matplotlib
    from matplotlib.figure import Figure

# a part of a summary: a paragraph or a table
Section = str | Table


class Report(ABC):
    """Tables, figures and text of one kind of benchmark.

    A report receives every trial while it is in memory, at its full rate, and keeps what it needs
    for its tables.
    """

    # requirement of this report on a trial, for messages
    expects: ClassVar[str] = "a segment with a reference angle"

    def observe(
        self,
        trial: Trial,
        calibrated: Mapping[str, CalibratedSegment],
        methods: Mapping[str, OrientationMethod],
        evaluated: Sequence[Evaluated],
    ) -> tuple[Sequence[Evaluated], Sequence[Refusal]]:
        """Process one trial, and select the samples to score.

        Parameters
        ----------
        trial : Trial
            The trial.
        calibrated : mapping of str to CalibratedSegment
            Its segments.
        methods : mapping of str to OrientationMethod
            Methods that were run, by name.
        evaluated : sequence of Evaluated
            Angles of segments and joints at the full rate.

        Returns
        -------
        evaluated : sequence of Evaluated
            Angles for ``results.csv``: the same, or fewer.
        refusals : sequence of Refusal
            Parts of the trial that are not suitable, and why.
        """
        return evaluated, ()

    @abstractmethod
    def sections(self, cfg: DictConfig, gathered: Gathered) -> list[Section]:
        """Write text and tables on the results.

        Parameters
        ----------
        cfg : omegaconf.DictConfig
            The benchmark's configuration.
        gathered : Gathered
            Its results.

        Returns
        -------
        list of str or Table
            Paragraphs and tables in order.

        Raises
        ------
        UserError
            If the results lack the data for the tables.
        """

    @abstractmethod
    def figures(self, cfg: DictConfig, gathered: Gathered) -> "dict[str, Figure]":
        """Draw the figures.

        Parameters
        ----------
        cfg : omegaconf.DictConfig
            The benchmark's configuration.
        gathered : Gathered
            Its results.

        Returns
        -------
        dict of str to matplotlib.figure.Figure
            By file name without suffix.
        """
