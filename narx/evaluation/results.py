"""Result table of a benchmark: one row per trial, segment, axis and method."""

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from narx.errors import UserError
from narx.files import atomic_path
from narx.kinematics.segment_angles import AXES

NAMES = ("dataset", "subject", "condition", "trial", "segment", "axis", "method")
NUMBERS = (
    "bias_deg", "precision_deg", "rmse_deg", "r", "loa_lower_deg", "loa_upper_deg", "lag_ms"
)  # fmt: skip
COLUMNS = (*NAMES, "n_samples", *NUMBERS)


def results_table(all_rows: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """Collect rows in one table.

    Parameters
    ----------
    all_rows : iterable of mapping
        From `narx.evaluation.comparison.rows`, of any number of trials.

    Returns
    -------
    pandas.DataFrame
        Columns `COLUMNS` with their types.
    """
    return _typed(pd.DataFrame(list(all_rows), columns=list(COLUMNS)))


def _typed(table: pd.DataFrame) -> pd.DataFrame:
    return table.astype(
        {**dict.fromkeys(NAMES, "str"), "n_samples": "int64", **dict.fromkeys(NUMBERS, "float64")}
    )


def write_results(results: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Write ``results.csv``.

    Parameters
    ----------
    results : pandas.DataFrame
        From `results_table`.
    path : path-like
        File to write, complete or not at all. A missing number is an empty field.
    """
    with atomic_path(path) as temporary:
        results[list(COLUMNS)].to_csv(temporary, index=False, lineterminator="\n")


def read_results(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read ``results.csv``.

    Parameters
    ----------
    path : path-like
        File written by `write_results`.

    Returns
    -------
    pandas.DataFrame
        Equal to the written table to the last digit.

    Raises
    ------
    UserError
        If the file is missing, is not such a table, or contains an invalid value.
    """
    try:
        # names are kept as text: subject "01" is not 1, and a subject named "NA" is not missing
        table = pd.read_csv(path, dtype=str, keep_default_na=False)
    except (OSError, UnicodeDecodeError, pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise UserError(f"{path}: cannot be read as CSV: {' '.join(str(error).split())}") from error
    if list(table.columns) != list(COLUMNS):
        raise UserError(
            f"{path}: header is '{','.join(table.columns)}', expected '{','.join(COLUMNS)}'"
        )
    if not Path(path).read_bytes().endswith(b"\n"):  # else a missing field were a missing number
        raise UserError(f"{path}: ends within a row, expected a line break at the end")
    _check(table["axis"].isin(AXES), table["axis"], path, f"one of {', '.join(AXES)}")
    _check(table["n_samples"].str.fullmatch(r"\d+"), table["n_samples"], path, "a count")
    for column in NUMBERS:
        text = table[column]
        # Python's own float parser is exact, unlike the fast one of pandas
        number = pd.Series([_number(value) for value in text], index=text.index, dtype="float64")
        limit = 1.0 if column == "r" else np.inf
        possible = (number.abs() <= limit) | (text == "")
        if column in ("precision_deg", "rmse_deg"):
            possible &= (number >= 0) | (text == "")
        expected = {"r": "a correlation", "lag_ms": "milliseconds"}.get(column, "degrees")
        _check(possible, text, path, f"{expected} or nothing")
        table[column] = number
    return _typed(table)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _check(
    valid: pd.Series, column: pd.Series, path: str | os.PathLike[str], expected: str
) -> None:
    wrong = np.flatnonzero(~valid.to_numpy(dtype=bool))
    if wrong.size:
        k = int(wrong[0])
        raise UserError(
            f"{path}, row {k + 1}: {column.name} is '{column.iloc[k]}', expected {expected}"
        )
