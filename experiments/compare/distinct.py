"""Runs found in several folders: the same run counts once, and every other has its own name."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from narx.errors import UserError
from narx.experiments.compare.runs import Run, plain
from narx.experiments.runs.folder import read_record

# processors round differently; a run on another one is still the same
_ROUNDING = 1e-6


def distinct_runs(runs: Sequence[Run]) -> list[Run]:
    """Leave out repetitions: runs with the configuration, seeds and fold of an earlier one.

    Parameters
    ----------
    runs : sequence of Run
        Finished runs, for example of two sweeps with jobs in common.

    Returns
    -------
    list of Run
        The first of each, in the same order.

    Raises
    ------
    UserError
        If the metrics of a repetition differ from those of the first by more than rounding, as
        after a change of the code or of the recordings.
    """
    first: dict[object, Run] = {}
    for run in runs:
        # as in the groups of the table, a key that is missing equals one without a value
        settings = frozenset(
            (k, isinstance(v, bool), plain(v))  # True equals 1
            for k, v in run.settings.items()
            if v is not None
        )
        kept = first.setdefault((settings, run.fold), run)
        different = _different_metric(kept, run)
        if different:
            raise UserError(
                f"{kept.folder} and {run.folder}: the same configuration and seed"
                f"{_cause(kept, run)}, but {different}; expected only one of them"
            )
    return list(first.values())


def _different_metric(first: Run, second: Run) -> str:
    for name in dict.fromkeys([*first.metrics, *second.metrics]):
        a, b = (run.metrics.get(name, np.nan) for run in (first, second))
        if not np.isclose(a, b, rtol=_ROUNDING, atol=0.0, equal_nan=True):
            return f"{name} is {a} and {b}"
    return ""


def _cause(first: Run, second: Run) -> str:
    a, b = (read_record(run.folder) or {} for run in (first, second))
    if a.get("data_sha256") != b.get("data_sha256"):
        return " on different data"
    return " with different versions of the code" if a.get("code") != b.get("code") else ""


def runs_by_name(runs: Sequence[Run]) -> dict[str, Run]:
    """Name runs by their folders.

    Parameters
    ----------
    runs : sequence of Run
        Runs.

    Returns
    -------
    dict of str to Run
        By the last part of the folder's path, or by the whole path where several runs share the
        last part; in the same order.
    """
    shared = Counter(run.folder.name for run in runs)
    return {
        run.folder.name if shared[run.folder.name] == 1 else str(run.folder): run for run in runs
    }
