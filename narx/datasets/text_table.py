"""Numbers in a text file, read strictly: a damaged line is reported, not skipped."""

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from narx.errors import RecordingError
from narx.recordings.input_file import LARGEST_NUMBER, regular_file
from narx.types import FloatArray


def read_numbers(
    path: Path,
    *,
    separator: str = r"\s+",
    columns: int | Sequence[str] | None = None,
    comment: str | None = None,
    terminated: bool = False,
    missing_allowed: bool = False,
) -> FloatArray:
    """Read a table of numbers from a text file.

    Parameters
    ----------
    path : pathlib.Path
        File to read.
    separator : str
        Regular expression between values.
    columns : int or sequence of str, optional
        A number: the file has no header and at least that many columns, of which the first ones
        are returned. Names: the file has a header line with at least these columns, which are
        returned in this order. None: all of a file without a header.
    comment : str, optional
        Lines that begin with this are left out.
    terminated : bool
        Whether the last line must end in a line break: without it a file cut off inside its
        last number would go unnoticed.
    missing_allowed : bool
        Whether a cell may be empty, ``n/a`` or NaN: a missing value.

    Returns
    -------
    ndarray, shape (N, number of columns)
        The values; finite, or NaN where `missing_allowed`.

    Raises
    ------
    RecordingError
        If the file is missing, empty, lacks a column, or contains something other than finite
        numbers up to 1e100; the message names file, line and column.
    """
    lines = _lines(path, comment, terminated)
    header = None if columns is None or isinstance(columns, int) else list(columns)
    if len(lines) < (1 if header is None else 2):
        raise RecordingError(f"{path}: no data lines, expected numbers")
    split = re.compile(separator).split
    if header is None:
        body, width = lines, len(split(lines[0][1]))
        count = columns if isinstance(columns, int) else width
        if width < count:
            raise RecordingError(
                f"{path}: line {body[0][0]} has {width} columns, expected at least {count}"
            )
        labels, chosen = [str(k + 1) for k in range(width)], list(range(count))
    else:
        body, labels = lines[1:], [name.strip() for name in split(lines[0][1])]
        missing = [name for name in header if name not in labels]
        if missing:
            raise RecordingError(
                f"{path}: no column '{missing[0]}' in the header; found {', '.join(labels)}"
            )
        width, chosen = len(labels), [labels.index(name) for name in header]
    numbers = np.empty((len(body), len(chosen)))
    for row, (line, text) in enumerate(body):
        cells = split(text)
        if len(cells) != width:
            raise RecordingError(
                f"{path}: line {line} has {len(cells)} values, expected {width} (cut off?)"
            )
        for k, column in enumerate(chosen):
            numbers[row, k] = _number(cells[column], missing_allowed)
            if abs(numbers[row, k]) > LARGEST_NUMBER:
                size = "" if np.isinf(numbers[row, k]) else f" of at most {LARGEST_NUMBER:.0e}"
                raise RecordingError(
                    f"{path}: line {line}, column {labels[column]}: found '{cells[column]}', "
                    f"expected a number{size}"
                )
    return numbers


def _number(cell: str, missing_allowed: bool) -> float:
    """Return the number in a cell, infinite if there is none."""
    try:
        number = float(cell)
    except ValueError:
        return math.nan if missing_allowed and cell.strip() in ("", "n/a") else math.inf
    return number if missing_allowed or not math.isnan(number) else math.inf


def _lines(path: Path, comment: str | None, terminated: bool) -> list[tuple[int, str]]:
    """Return the numbered lines that are not empty."""
    try:
        text = regular_file(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RecordingError(f"{path}: cannot be read as text ({error})") from None
    if terminated and text and not text.endswith("\n"):
        raise RecordingError(
            f"{path}: line {text.count(chr(10)) + 1} is the last and has no line break (cut off?)"
        )
    return [
        (number, line.strip())
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not (comment and line.lstrip().startswith(comment))
    ]
