"""Paired comparison of two configurations on the same folds, with a confidence interval."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from narx.errors import UserError
from narx.evaluation.results import read_results
from narx.evaluation.significance import PairedTest, paired_test
from narx.experiments.compare.runs import is_seed


@dataclass(frozen=True)
class Pairing:
    """Comparison of two configurations.

    Parameters
    ----------
    first, second : int
        Their ranks.
    unit : {"person", "seed"}
        Unit of pairing: people on whom both were tested, or runs with the same seed and fold.
    test : PairedTest
        First minus second.
    """

    first: int
    second: int
    unit: str
    test: PairedTest

    def sentence(self, metric: str) -> str:
        """Describe the result.

        Parameters
        ----------
        metric : str
            Name of the compared metric.

        Returns
        -------
        str
            Difference with its interval and test, or the reason why there is none.
        """
        test = self.test
        if test.n < 2:
            return (
                f"Configurations {self.first} and {self.second} share {test.n} "
                f"{self.unit}{'' if test.n == 1 else 's'}: too few for an interval."
            )
        interval = (
            f"95 % interval {test.low:+.3f} to {test.high:+.3f}"
            if np.isfinite(test.low)
            else f"too few {self.unit}s for an interval"
        )
        return (
            f"Configuration {self.first} less {self.second}, {metric} on the same {test.n} "
            f"{self.unit}s: {test.difference:+.3f}, {interval}; "
            f"p {test.p_permutation:.2g} (permutation; {test.n} pairs cannot give less than "
            f"{test.smallest_p:.2g})."
        )


def compare_pair(
    table: pd.DataFrame, folders: dict[str, Path], metric: str, first: int, second: int
) -> Pairing:
    """Compare two configurations on the people or runs that they share.

    Parameters
    ----------
    table : pandas.DataFrame
        From `narx.experiments.compare.runs.runs_table`.
    folders : dict of str to pathlib.Path
        Folder of each run, by its name in the table.
    metric : str
        Metric to compare.
    first, second : int
        Ranks.

    Returns
    -------
    Pairing
        Over people if both are benchmarks, otherwise over runs with the same seed and fold.

    Raises
    ------
    UserError
        If these are not the ranks of two configurations.
    """
    last = int(table["rank"].max())
    if last == 1:
        raise UserError(f"--pair {first} {second}: there is only one configuration, expected two")
    if first == second or not {first, second} <= set(range(1, last + 1)):
        raise UserError(
            f"--pair {first} {second}: expected the ranks of two configurations, "
            f"{'1 and 2' if last == 2 else f'two of 1 to {last}'}"
        )
    a, b = (table[table["rank"] == rank] for rank in (first, second))
    if (a["fold"] == "").all() and (b["fold"] == "").all():
        left, right = (_by_person(rows, folders) for rows in (a, b))
        unit = "person"
    else:
        seeds = [str(column) for column in table if is_seed(str(column))]
        left, right = (rows.set_index([*seeds, "fold"])[metric] for rows in (a, b))
        unit = "seed"
    both = pd.concat({"a": left, "b": right}, axis=1, join="inner")
    return Pairing(first, second, unit, paired_test(both["a"].to_numpy(), both["b"].to_numpy()))


def _by_person(rows: pd.DataFrame, folders: dict[str, Path]) -> pd.Series:
    results = pd.concat(
        [read_results(folders[str(run)] / "results.csv") for run in rows["run"]], ignore_index=True
    )
    network = results[results["method"] == "narx"]
    return network.groupby(["dataset", "subject"])["rmse_deg"].mean()
