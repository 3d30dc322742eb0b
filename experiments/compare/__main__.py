"""Rank all runs of sweeps, average over seeds, and show what differs.

narx-compare DIR...
"""

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from pandas.api.types import is_float_dtype

from narx.errors import UserError
from narx.experiments.compare.distinct import distinct_runs, runs_by_name
from narx.experiments.compare.pairing import Pairing, compare_pair
from narx.experiments.compare.runs import (
    Run,
    choose_metric,
    configurations_table,
    differing_keys,
    find_runs,
    is_seed,
    runs_table,
)
from narx.experiments.runs.folder import read_record
from narx.experiments.runs.sweep import USER_ERROR_STATUS
from narx.experiments.starting import (
    INTERRUPTED_STATUS,
    end_if_output_is_closed,
    imported,
    interrupted,
    pipe_may_close,
)
from narx.experiments.tables.table import Table
from narx.files import atomic_path

_PLACES = frozenset({"data_root", "prepared.folder"})


def best_overrides(run: Run) -> str:
    """Return the overrides that reproduce a run's configuration.

    Parameters
    ----------
    run : Run
        The run.

    Returns
    -------
    str
        The overrides, quoted for a shell, without seeds and paths.
    """
    chosen = [
        override
        for override in run.overrides
        if not is_seed(key := override.partition("=")[0].lstrip("+")) and key not in _PLACES
    ]
    return " ".join(map(shlex.quote, chosen))


def compare(
    directories: list[Path], metric: str | None, pair: tuple[int, int] | None, output: Path | None
) -> str:
    """Compare all finished runs below some folders.

    Parameters
    ----------
    directories : list of pathlib.Path
        Folders to search for runs.
    metric : str, optional
        Metric for the ranking; by default the held-out error of trainings or the RMSE of
        benchmarks.
    pair : tuple of (int, int), optional
        Ranks of the two configurations to test against each other; the first two by default.
    output : pathlib.Path, optional
        Where ``runs.csv``, ``runs.parquet`` and ``comparison.html`` are written; the first folder
        by default.

    Returns
    -------
    str
        Text to print: the configurations, the overrides of the best one, the paired comparison.

    Raises
    ------
    UserError
        If there is nothing to compare, a run that was found twice has two results, or a library
        for the report is not installed.
    """
    try:  # imported here, since training needs neither these libraries nor the time to import them
        from narx.experiments.compare.report import readable, write_report
    except ModuleNotFoundError as error:
        raise UserError(
            f"narx-compare needs {error.name}: pip install 'narx-orientation[sweep]'"
        ) from error
    found, others = find_runs(directories)
    runs = distinct_runs(found)
    repeated = len(found) - len(runs)
    named = runs_by_name(runs)
    metric = choose_metric(runs, metric)
    keys = differing_keys(runs)
    table = runs_table(named, metric)
    ranked = configurations_table(table, keys)
    folders = {name: run.folder for name, run in named.items()}
    histories = {name: run.history for name, run in named.items()}
    pairing: Pairing | None = None
    if pair is not None or len(ranked) > 1:
        pairing = compare_pair(table, folders, metric, *(pair or (1, 2)))
    target = directories[0] if output is None else output
    best = named[table["run"].iloc[0]]
    lines = [
        _markdown(readable(ranked), metric),
        *_different_data(runs),
        f"best: narx-{best.command} {best_overrides(best)}".rstrip(),
        *([] if pairing is None else [pairing.sentence(metric)]),
        *([f"unfinished runs left out: {len(others)}"] if others else []),
        *(
            [f"repeated runs left out: {repeated} (configuration, seed and results of another)"]
            if repeated
            else []
        ),
        *_unequal(ranked),
    ]
    report = target / "comparison.html"
    write_report(report, table, histories, best.folder, metric, keys, lines[1:])
    with atomic_path(target / "runs.csv") as temporary:
        table.to_csv(temporary, index=False)
    with atomic_path(target / "runs.parquet") as temporary:
        table.to_parquet(temporary, index=False)
    lines.append(f"{len(table)} runs: {target / 'runs.csv'}, runs.parquet, comparison.html")
    return "\n\n".join(lines)


def _different_data(runs: Sequence[Run]) -> list[str]:
    """Warn that errors on different recordings are ranked."""
    records = [read_record(run.folder) or {} for run in runs]
    n = len({json.dumps(record.get("data_sha256"), sort_keys=True) for record in records})
    if n == 1:
        return []
    return [
        f"the runs used {n} different sets of recordings: errors on one cannot be compared with "
        "those on another"
    ]


def _unequal(ranked: pd.DataFrame) -> list[str]:
    """Warn that means over different numbers of runs are ranked, as in an unfinished sweep."""
    least, most = int(ranked["n"].min()), int(ranked["n"].max())
    if least == most:
        return []
    return [f"configurations have {least} to {most} runs: their ranks may change with the others"]


def _markdown(ranked: pd.DataFrame, metric: str) -> str:
    decimals = {"rank": 0, "n": 0, "mean": 3, "sd": 3}
    # settings may be far below one
    settings = {
        str(key): values.map("{:g}".format, na_action="ignore")
        for key, values in ranked.items()
        if key not in decimals and is_float_dtype(values)
    }
    text = ranked.assign(**settings)
    return Table(f"{metric}, mean and SD over seeds", text, decimals).to_markdown().strip()


@pipe_may_close()
def main() -> None:
    """Run the command with the arguments on the command line."""
    imported()
    parser = argparse.ArgumentParser(
        "narx-compare",
        description=__doc__,
        epilog="example: narx-compare multirun/2026-01-31/10-00-00 --metric rmse_deg --pair 1 3; "
        "prints the configurations with mean and SD over seeds, the command of the best one and a "
        "paired test, and writes runs.csv, runs.parquet and comparison.html",
    )
    parser.add_argument("directory", nargs="+", type=Path, help="folder of a sweep or of runs")
    parser.add_argument("--metric", help="of metrics.json, such as rmse_deg; smaller is better")
    parser.add_argument(
        "--pair",
        nargs=2,
        type=int,
        metavar=("RANK", "RANK"),
        help="test these two, 1 2 if not given",
    )
    parser.add_argument(
        "--output", type=Path, help="folder for table and report, the first if not given"
    )
    arguments = parser.parse_args()
    try:
        pair = None if arguments.pair is None else (arguments.pair[0], arguments.pair[1])
        print(compare(arguments.directory, arguments.metric, pair, arguments.output))
    except KeyboardInterrupt:
        sys.exit(_interrupted())
    except (UserError, OSError) as error:
        if interrupted():
            sys.exit(_interrupted())
        end_if_output_is_closed(error)
        print(f"error: {_described(error)}", file=sys.stderr)
        sys.exit(USER_ERROR_STATUS)


def _interrupted() -> int:
    print("interrupted: repeat the command to start again", file=sys.stderr)
    return INTERRUPTED_STATUS


def _described(error: UserError | OSError) -> str:
    if isinstance(error, UserError):
        return str(error)
    where = error.filename or "output"
    return f"{where}: {error.strerror}; expected a writable folder (--output DIR)"


if __name__ == "__main__":
    main()
