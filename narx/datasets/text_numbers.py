"""Numbers in the cells of text files: decimal marks, groups of thousands, missing values."""

import re
from pathlib import Path

import numpy as np

from narx.errors import RecordingError
from narx.types import FloatArray

MISSING = frozenset(
    ("", "na", "n/a", "#n/a", "nan", "-nan", "null", "none", "nil", "<na>", "-", "--", "?", ".",
     "missing", "#value!", "#num!", "n.a.", "---", "----", "*", "''", "k.a.", "void", "invalid",
     "#div/0!", "#ref!", "<null>", "n.d.", "nd", "nan(ind)", "-nan(ind)", "1.#qnan", "-1.#ind",
     "no data", "nodata", "no_data", "undefined", "undef", "\u2013", "\u2014", "/", "...", "_")
)  # fmt: skip
_NUMBER = re.compile(r"[+-]?(\d+([., '\u00a0\u202f]\d+)*[.,]?|[.,]\d+)([eE][+-]?\d+)?")
_GROUPED = {
    ".": re.compile(r"[+-]?\d{1,3}([, '\u00a0\u202f]\d{3})+(\.\d*)?"),
    ",": re.compile(r"[+-]?\d{1,3}([. '\u00a0\u202f]\d{3})+(,\d*)?"),
}


def is_number(cell: str) -> bool:
    """Return whether a cell is a number in any form.

    Parameters
    ----------
    cell : str
        Cell of a table.

    Returns
    -------
    bool
        False for a missing value as well.
    """
    return bool(_NUMBER.fullmatch(cell.strip()))


def decimal_of(rows: list[list[str]], path: Path) -> str:
    """Determine the decimal mark.

    Parameters
    ----------
    rows : list of list of str
        Cells of all data lines.
    path : pathlib.Path
        The file, for messages.

    Returns
    -------
    {".", ","}
        The mark.

    Raises
    ------
    RecordingError
        If both occur.
    """
    points = commas = 0
    for row in rows[:: max(1, len(rows) // 1000)]:
        for cell in row:
            if is_number(cell):
                point, comma = cell.rfind("."), cell.rfind(",")
                grouped = cell.count(",") > 1 or cell.count(".") > 1
                if point >= 0 and comma >= 0:
                    return "." if point > comma else ","
                points += point >= 0 and not grouped
                commas += comma >= 0 and not grouped
    if points and commas:
        grouped_commas = all(
            _GROUPED["."].fullmatch(cell.strip())
            for row in rows
            for cell in row
            if "," in cell and is_number(cell)
        )
        if grouped_commas:
            return "."
        grouped_points = all(
            _GROUPED[","].fullmatch(cell.strip())
            for row in rows
            for cell in row
            if "." in cell and is_number(cell)
        )
        if not grouped_points:
            raise RecordingError(f"{path}: numbers with decimal points and with decimal commas")
    return "," if commas else "."


def plain_numbers(cells: list[str]) -> FloatArray | None:
    """Convert all cells at once.

    Parameters
    ----------
    cells : list of str
        A column.

    Returns
    -------
    ndarray, shape (N,), or None
        None if one cell is not a number with a decimal point.
    """
    if "_" in "".join(cells):  # characters of numbers that only Python accepts
        return None
    try:
        return np.fromiter(map(float, cells), dtype=np.float64, count=len(cells))
    except ValueError:
        return None


def number_in(cell: str, decimal: str) -> float:
    """Convert a cell.

    Parameters
    ----------
    cell : str
        Without blanks around it.
    decimal : {".", ","}
        Decimal mark.

    Returns
    -------
    float
        NaN if it is missing, infinite if it is not a number.
    """
    try:
        # a point among decimal commas, and numbers valid only in Python
        if "_" in cell or (decimal == "," and "." in cell):
            raise ValueError
        return float(cell.replace(decimal, "."))
    except ValueError:
        if cell.lower() in MISSING:
            return np.nan
        if _GROUPED[decimal].fullmatch(cell):
            whole, _, part = cell.partition(decimal)
            return float(f"{re.sub(r'[^0-9+-]', '', whole)}.{part or '0'}")
        return np.inf
