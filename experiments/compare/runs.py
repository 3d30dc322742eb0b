"""Collect finished runs: their settings and their metrics."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from pydantic import BaseModel, TypeAdapter, ValidationError
from yaml import YAMLError

from narx.errors import UserError
from narx.experiments.runs.folder import RECORD, read_record
from narx.experiments.runs.identity import flat_settings

# metrics for ranking configurations, in order of preference: of trainings and of benchmarks
METRICS = ("held_back_error_deg", "rmse_deg")
SEED = "seed"


class _Report(BaseModel):
    history: list[dict[str, Any]]


class _Training(BaseModel):
    fold: str
    report: _Report


_METRICS = TypeAdapter(dict[str, float | None])
_TRAINING = TypeAdapter(_Training)
T = TypeVar("T")


@dataclass(frozen=True)
class Run:
    """One finished run.

    Parameters
    ----------
    folder : pathlib.Path
        Its folder.
    settings : dict
        Its resolved configuration, one value for each dotted key.
    overrides : tuple of str
        Overrides on the command line.
    metrics : dict of str to float
        By name; ``rmse_deg`` is the mean over all segments and axes of the network.
    command : str
        Name of the command that made it.
    fold : str
        Name of the training fold; empty for a benchmark.
    history : list of dict
        Iterations of the best start; empty for a benchmark.
    """

    folder: Path
    settings: dict[str, Any]
    overrides: tuple[str, ...]
    metrics: dict[str, float]
    command: str
    fold: str
    history: list[dict[str, Any]]


def is_seed(key: str) -> bool:
    """Return whether a key is a seed; configurations are averaged over seeds.

    Parameters
    ----------
    key : str
        Dotted key.

    Returns
    -------
    bool
        True for ``seed`` and ``<anything>.seed``.
    """
    return key.rpartition(".")[2] == SEED


def find_runs(directories: Iterable[Path]) -> tuple[list[Run], list[Path]]:
    """Find all runs below some folders.

    Parameters
    ----------
    directories : iterable of pathlib.Path
        Folders of sweeps or of single runs, or parent folders of these.

    Returns
    -------
    runs : list of Run
        Finished runs, in the order of their folders; a folder given twice counts once.
    others : list of pathlib.Path
        Folders of runs that have failed, were interrupted, or are still running.

    Raises
    ------
    UserError
        If one is not a folder, or none contains a finished run with a metric to compare.
    """
    directories = list(directories)
    folders: dict[Path, Path] = {}
    for directory in directories:
        if not directory.is_dir():
            found = "a file" if directory.exists() else "no such folder"
            raise UserError(f"{directory}: {found}, expected a folder of a sweep or of runs")
        for path in sorted(directory.rglob(RECORD)):
            folders.setdefault(path.parent.resolve(), path.parent)
    runs, others = [], []
    for folder in folders.values():
        record = read_record(folder)
        assert record is not None
        if record["state"] != "finished":
            others.append(folder)
        elif (folder / "metrics.json").is_file():
            runs.append(_read_run(folder))
    if not runs:
        where = ", ".join(map(str, directories))
        raise UserError(f"{where}: no finished run of narx-train or narx-benchmark")
    return runs, others


def _read_run(folder: Path) -> Run:
    try:
        hydra = folder / ".hydra"
        settings = flat_settings(_section(hydra / "config.yaml"))
        overrides = list(OmegaConf.load(hydra / "overrides.yaml"))
        made_by = hydra / "hydra.yaml"
        command = _section(made_by).hydra.job.name if made_by.exists() else "train"
        metrics = _json(_METRICS, folder / "metrics.json")
        if not metrics:
            raise ValueError("metrics.json is empty")
        training, fold, history = folder / "training.json", "", []
        if training.exists():
            read = _json(_TRAINING, training)
            fold, history = read.fold, read.report.history
    except (OSError, ValueError, TypeError, YAMLError, OmegaConfBaseException) as error:
        reason = " ".join(str(error).split())
        raise UserError(f"{folder}: not the folder of a finished run ({reason})") from error
    numbers = pd.Series(metrics, dtype=float)
    rmse = numbers[numbers.index.str.startswith("rmse_deg/") & numbers.index.str.endswith("/narx")]
    if len(rmse):
        numbers["rmse_deg"] = rmse.mean()
    texts = tuple(map(str, overrides))
    return Run(folder, settings, texts, dict(numbers), str(command), fold, history)


def _json(kind: TypeAdapter[T], path: Path) -> T:
    try:
        return kind.validate_json(path.read_bytes())
    except ValidationError as error:
        raise ValueError(f"{path.name}: {error.errors()[0]['msg']}") from None


def _section(path: Path) -> DictConfig:
    content = OmegaConf.load(path)
    if not isinstance(content, DictConfig) or not content:
        raise TypeError(f"{path.name} has no keys")
    return content


def differing_keys(runs: Sequence[Run]) -> list[str]:
    """List the keys whose values differ between runs.

    Parameters
    ----------
    runs : sequence of Run
        To compare.

    Returns
    -------
    list of str
        In the order of the configuration, without seeds.
    """
    keys = list(dict.fromkeys(key for run in runs for key in run.settings))
    return [
        key
        for key in keys
        if not is_seed(key) and len({repr(run.settings.get(key)) for run in runs}) > 1
    ]


def choose_metric(runs: Sequence[Run], wanted: str | None) -> str:
    """Choose the metric by which runs are ranked.

    Parameters
    ----------
    runs : sequence of Run
        Runs, which must all have the metric.
    wanted : str, optional
        Its name; by default the first of `METRICS` that all runs have.

    Returns
    -------
    str
        Name of a metric; smaller is better.

    Raises
    ------
    UserError
        If a run does not have it.
    """
    shared = set.intersection(*(set(run.metrics) for run in runs))
    names = METRICS if wanted is None else (wanted,)
    for name in names:
        if name in shared:
            return name
    raise UserError(
        f"--metric: not all runs have {' or '.join(names)}, expected one of "
        f"{', '.join(sorted(shared)) or 'nothing: these runs have no metric in common'}"
    )


def runs_table(runs: Mapping[str, Run], metric: str) -> pd.DataFrame:
    """Put runs into one table, the best configuration first.

    Parameters
    ----------
    runs : mapping of str to Run
        To compare, by name.
    metric : str
        Metric for the ranking.

    Returns
    -------
    pandas.DataFrame
        One row per run: ``rank`` of its configuration; ``mean``, ``sd`` and ``n`` of the metric
        over the runs of that configuration, which differ only in their seeds; the keys that
        differ; ``seed`` and the seeds that differ from it in a run; fold; metrics; ``run``, its
        name. Times are left out, so that two sweeps with the same results have the same table.
    """
    differing = differing_keys(list(runs.values()))
    rows = []
    seed_keys = dict.fromkeys(key for run in runs.values() for key in run.settings if is_seed(key))
    own_seeds = {
        key
        for key in seed_keys
        for run in runs.values()
        if key == "seed" or run.settings.get(key) != run.settings.get("seed")
    }
    for name, run in runs.items():
        seeds = {key: run.settings.get(key) for key in seed_keys if key in own_seeds}
        settings = {key: plain(run.settings.get(key)) for key in differing}
        rows.append({**settings, **seeds, "fold": run.fold, **run.metrics, "run": name})
    given = {*differing, *own_seeds}
    table = pd.DataFrame(
        {
            key: _of_one_kind(values) if key in given else values
            for key, values in pd.DataFrame(rows).items()
        }
    )
    number = pd.Series(range(len(table)), index=table.index)
    if differing:
        number = table.groupby(differing, dropna=False, sort=False).ngroup()
    else:
        number[:] = 0
    by = table[metric].groupby(number)
    table.insert(0, "mean", number.map(by.mean()))
    table.insert(1, "sd", number.map(by.std()))
    table.insert(2, "n", number.map(by.count()))
    order = by.mean().rank(method="first", na_option="bottom").astype(int)
    table.insert(0, "rank", number.map(order))
    by_seed = [str(column) for column in table if is_seed(str(column))]
    return table.sort_values(["rank", *by_seed, "run"], kind="stable").reset_index(drop=True)


def configurations_table(table: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    """Reduce a table of runs to its configurations.

    Parameters
    ----------
    table : pandas.DataFrame
        From `runs_table`.
    keys : sequence of str
        Keys that differ.

    Returns
    -------
    pandas.DataFrame
        One row per configuration: ``rank``, ``mean``, ``sd``, ``n`` and the keys.
    """
    columns = ["rank", "mean", "sd", "n", *keys]
    return table.drop_duplicates("rank")[columns].reset_index(drop=True)


def _of_one_kind(values: pd.Series) -> pd.Series:
    """Write values as text where numbers, words and switches are mixed, such as 3 and auto.

    A column of Parquet has one type, and True would be grouped with 1.
    """
    given = values[values.notna()]
    if given.map(lambda value: isinstance(value, str) + 2 * isinstance(value, bool)).nunique() < 2:
        return values
    return given.map(lambda value: str(value).lower() if isinstance(value, bool) else str(value))


def plain(value: object) -> object:
    """Convert a setting to a value that can be grouped.

    Parameters
    ----------
    value : object
        Value of a key.

    Returns
    -------
    bool, int, float, str or None
        Itself, or the text of anything else, such as a list.
    """
    return value if isinstance(value, bool | int | float | str) or value is None else str(value)
