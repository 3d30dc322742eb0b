"""The results of a benchmark once all its trials have run."""

from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from narx.evaluation.comparison import Evaluated
from narx.evaluation.trial import Refusal
from narx.evaluation.workload import Workload
from narx.inference.checkpoint import Checkpoint


@dataclass
class Gathered:
    """All results that tables and figures are made from.

    Parameters
    ----------
    results : pandas.DataFrame
        The rows of ``results.csv``.
    evaluated : list of Evaluated
        Decimated, for figures: joints if there are any, otherwise segments.
    refusals : list of Refusal
        Methods that were not applicable to a recording.
    networks : dict of str to Checkpoint
        By fold; empty if no network ran.
    sources : dict of str to str
        SHA-256 of each data file.
    notes : list of str
        Changes that the sources made to their data.
    workload : Workload
        Time spent in each method.
    chosen : dict of tuple of str to dict
        Chosen parameters, by fold and row.
    not_causal : set of str
        Rows that use later samples.
    """

    results: pd.DataFrame
    evaluated: list[Evaluated] = field(default_factory=list)
    refusals: list[Refusal] = field(default_factory=list)
    networks: dict[str, Checkpoint] = field(default_factory=dict)
    sources: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    workload: Workload = field(default_factory=Workload)
    chosen: dict[tuple[str, str], dict[str, Any]] = field(default_factory=dict)
    not_causal: set[str] = field(default_factory=set)
