"""What a benchmark has gathered once all its trials have run."""

from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from narx.evaluation.comparison import Evaluated
from narx.evaluation.trial import Refusal
from narx.evaluation.workload import Workload
from narx.inference.checkpoint import Checkpoint


@dataclass
class Gathered:
    """Everything that tables and figures are made from.

    Parameters
    ----------
    results : pandas.DataFrame
        The rows of ``results.csv``.
    evaluated : list of Evaluated
        Thinned out, for figures: joints where there are any, else segments.
    refusals : list of Refusal
        Methods that a recording did not fit.
    networks : dict of str to Checkpoint
        By fold; empty where no network ran.
    sources : dict of str to str
        Data files and their SHA-256.
    notes : list of str
        What the sources did to their data.
    workload : Workload
        Time in each method.
    chosen : dict of tuple of str to dict
        Parameters that were chosen, by fold and row.
    not_causal : set of str
        Rows that look ahead.
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
