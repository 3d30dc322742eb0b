"""The one interface of all reports: look at every trial, then say what came out."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar

from matplotlib.figure import Figure
from omegaconf import DictConfig

from narx.calibration.calibrate import CalibratedSegment
from narx.evaluation.comparison import Evaluated
from narx.evaluation.trial import Refusal
from narx.experiments.gathered import Gathered
from narx.experiments.tables.table import Table
from narx.method import OrientationMethod
from narx.recordings.trial import Trial

# what a summary is made of: a paragraph or a table
Section = str | Table


class Report(ABC):
    """Tables, figures and text of one kind of benchmark.

    A report is shown every trial while it is in memory, at its full rate; what it needs for its
    own tables it takes then.
    """

    # in the words of a person: what a trial must have for this report
    expects: ClassVar[str] = "a segment with a reference angle"

    def observe(
        self,
        trial: Trial,
        calibrated: Mapping[str, CalibratedSegment],
        methods: Mapping[str, OrientationMethod],
        evaluated: Sequence[Evaluated],
    ) -> tuple[Sequence[Evaluated], Sequence[Refusal]]:
        """Look at one trial, and say which of its samples count.

        Parameters
        ----------
        trial : Trial
            The trial.
        calibrated : mapping of str to CalibratedSegment
            Its segments.
        methods : mapping of str to OrientationMethod
            Those that ran, by name.
        evaluated : sequence of Evaluated
            Angles of segments and joints at the full rate.

        Returns
        -------
        evaluated : sequence of Evaluated
            What goes into ``results.csv``: the same, or less.
        refusals : sequence of Refusal
            What of the trial does not fit, and why.
        """
        return evaluated, ()

    @abstractmethod
    def sections(self, cfg: DictConfig, gathered: Gathered) -> list[Section]:
        """Write what is said of the results.

        Parameters
        ----------
        cfg : omegaconf.DictConfig
            The benchmark's configuration.
        gathered : Gathered
            Its results.

        Returns
        -------
        list of str or Table
            Paragraphs and tables in their order.

        Raises
        ------
        UserError
            If the results hold nothing that the tables are made of.
        """

    @abstractmethod
    def figures(self, cfg: DictConfig, gathered: Gathered) -> dict[str, Figure]:
        """Draw.

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
