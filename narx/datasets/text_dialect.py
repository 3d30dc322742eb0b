"""Tables in text files as written by devices, phones and spreadsheets.

Encoding, separator, decimal mark, header, units row and index column are detected from the file;
deviations from plain CSV are noted. A damaged line is reported, not skipped.
"""

import csv
import re
from collections import Counter
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import numpy as np

from narx.datasets.calendar_times import seconds_of
from narx.datasets.text_encoding import decoded
from narx.datasets.text_numbers import MISSING, decimal_of, is_number, number_in, plain_numbers
from narx.datasets.units import is_unit
from narx.errors import RecordingError
from narx.recordings.input_file import check_memory, regular_file
from narx.types import FloatArray

_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
# of text, as lines of cells
_MEMORY_PER_BYTE = 12
_COMMENT = ("#", "%", "//")
# lines used to detect the dialect, spread over the file
_SAMPLE = 60
# calibrated and raw signals of the same name, in a row below it
_STAGES = frozenset(("CAL", "RAW", "UNCAL"))
_WHOLE_QUOTED = re.compile(r'\s*"[^"]*[,;\t|][^"]*"\s*')


@dataclass(frozen=True)
class TextTable:
    """Cells of a text file with column names.

    Parameters
    ----------
    path : pathlib.Path
        The file, for messages.
    names : tuple of str
        One name per column; empty for an index column without one.
    units : tuple of str, or None
        Units row below the header, if any.
    rows : list of list of str
        Cells of every data line, as many as there are names.
    line_numbers : list of int
        Line number of each row in the file, from 1.
    decimal : {".", ","}
        Decimal mark.
    ends_in_line_break : bool
        Whether the last line is complete.
    comments : tuple of str
        Lines of comment or metadata above the header.
    notes : tuple of str
        Deviations from plain CSV, as text.
    """

    path: Path
    names: tuple[str, ...]
    units: tuple[str, ...] | None
    rows: list[list[str]]
    line_numbers: list[int]
    decimal: str
    ends_in_line_break: bool
    comments: tuple[str, ...]
    notes: tuple[str, ...]

    def _cells(self, column: int) -> list[str]:
        return [row[column].strip() for row in self.rows]

    def numbers(self, column: int) -> FloatArray:
        """Return a column of numbers.

        Parameters
        ----------
        column : int
            From 0.

        Returns
        -------
        ndarray, shape (N,)
            NaN where a cell is empty or marked as missing.

        Raises
        ------
        RecordingError
            If a cell is not a finite number; the message names line and column.
        """
        cells = self._cells(column)
        numbers = plain_numbers(cells) if self.decimal == "." else None
        if numbers is None:
            numbers = np.array([number_in(cell, self.decimal) for cell in cells])
        wrong = np.flatnonzero(np.isinf(numbers))
        if wrong.size:
            first = int(wrong[0])
            raise RecordingError(
                f"{self.path}: line {self.line_numbers[first]}, column {self.names[column]}: "
                f"found '{cells[first][:40]}', expected a number"
            )
        if np.isnan(numbers[-1:]).any() and not self.ends_in_line_break:
            raise RecordingError(
                f"{self.path}: the last line has an empty cell and no line break (cut off?)"
            )
        return numbers

    def seconds(self, column: int) -> tuple[FloatArray, tuple[str, ...]] | None:
        """Return a column of dates and times as seconds from the first.

        Parameters
        ----------
        column : int
            From 0.

        Returns
        -------
        tuple of ndarray and tuple of str, or None
            Seconds and a note; None for a column of numbers.

        Raises
        ------
        RecordingError
            If a cell is not a date and time.
        """
        cells = self._cells(column)
        if sum(":" in cell for cell in cells) <= len(cells) // 2:
            return None
        seconds = seconds_of(cells)
        wrong = np.flatnonzero(np.isnan(seconds))
        if wrong.size:
            first = int(wrong[0])
            raise RecordingError(
                f"{self.path}: line {self.line_numbers[first]}, column {self.names[column]}: "
                f"found '{cells[first][:40]}', expected a date and time"
            )
        return seconds, (f"times count from {cells[0]}",)


def read_table(path: Path, content: bytes | None = None) -> TextTable:
    """Read a table with a header line from a text file in any common dialect.

    Parameters
    ----------
    path : pathlib.Path
        Text in UTF-8, UTF-16 or a Western code page, with or without byte order mark; fields
        separated by commas, semicolons, tabs, bars or blanks; decimal point or comma, groups of
        thousands or none; quoted or not. Before the header there may be comment lines and a
        ``sep=`` line, below it a row of units; lines may begin with an index or end in a separator.

    content : bytes, optional
        Content of the file, if already read; `path` is then only its name.

    Returns
    -------
    TextTable
        Names, units and cells.

    Raises
    ------
    RecordingError
        If the file is not text or has no header above a table, or a line does not have as many
        cells as the others; the message is one line with file and place.
    """
    data = regular_file(path).read_bytes() if content is None else content
    check_memory(path, _MEMORY_PER_BYTE * len(data))
    text, notes = decoded(path, data)
    lines = [
        (number, line)
        for number, line in enumerate(re.split(r"\r\n|\n|\r", text), start=1)
        if line.strip()
    ]
    separator = None
    if lines and (declared := re.match(r'"?sep=(\\t|.)', lines[0][1], re.IGNORECASE)):
        separator = declared[1].replace("\\t", "\t")
        lines = lines[1:]
    if lines and max(len(line) for _, line in lines) > csv.field_size_limit():
        raise RecordingError(
            f"{path}: a line of more than {csv.field_size_limit()} letters, expected a table with "
            "one line per sample"
        )
    if lines and all(_WHOLE_QUOTED.fullmatch(line) for _, line in lines):
        # a spreadsheet took each line for one cell
        lines = [(number, line.strip()[1:-1]) for number, line in lines]
    comments = [(number, line) for number, line in lines if line.lstrip().startswith(_COMMENT)]
    lines = [(number, line) for number, line in lines if not line.lstrip().startswith(_COMMENT)]
    if not lines:
        raise RecordingError(f"{path}: empty, expected a header line")
    if separator is None:
        separator = _separator([line for _, line in lines])
    rows = _split([line for _, line in lines], separator)
    width = Counter(map(len, rows[len(rows) // 4 :])).most_common(1)[0][0]
    begin = next(
        (k for k, row in enumerate(rows) if _is_data(row, width) and any(map(is_number, row))),
        len(rows),
    )
    headers = [row for row in rows[:begin] if _is_remark(row)]
    kept = [k for k, row in enumerate(rows) if k < begin or row not in headers]
    if len(kept) < len(rows):
        # files joined into one
        notes.append(f"{len(rows) - len(kept)} repeated lines of the header left out")
        rows, lines = [rows[k] for k in kept], [lines[k] for k in kept]
    end = _end_of_data(rows, begin, width)
    if end < len(rows):
        notes.append(f"line {lines[end][0]} and the following left out, since they are not data")
    rows, lines = rows[:end], lines[:end]
    line_numbers = [number for number, _ in lines[begin:]]
    above = lines[:begin]
    if not line_numbers:
        raise RecordingError(f"{path}: no data lines, expected numbers")
    header, units = _header(path, rows[:begin], comments, width, separator)
    body, has_index = _even(path, rows[begin:], line_numbers, len(header))
    names = ["", *header] if has_index else header
    # between unquoted commas there is no decimal comma
    decimal = "." if separator == "," and '"' not in text else decimal_of(body, path)
    if separator != ",":
        notes.append(f"fields separated by {_SEPARATORS.get(separator, repr(separator))}")
    if decimal == ",":
        notes.append("decimal commas")
    return TextTable(
        path,
        tuple(names),
        units,
        body,
        line_numbers,
        decimal,
        text.endswith(("\n", "\r")),
        tuple(line.strip() for number, line in (*comments, *above) if number < line_numbers[0]),
        tuple([f"read as text: {', '.join(notes)}"] if notes else []),
    )


def _split(lines: list[str], separator: str) -> list[list[str]]:
    if separator == " ":
        return [line.split() for line in lines]
    # the csv module receives one line at a time, so that a stray quote cannot extend over lines
    quoted = [line.strip(" \r") if '"' in line else None for line in lines]
    return [
        line.split(separator)
        if inside is None
        else next(csv.reader([inside], delimiter=separator, skipinitialspace=True))
        for line, inside in zip(lines, quoted, strict=True)
    ]


def _separator(lines: list[str]) -> str:
    """Choose the separator that splits lines into equal numbers of numeric cells."""
    chosen = np.unique(np.linspace(len(lines) // 4, len(lines) - 1, _SAMPLE).astype(int))
    sample = [lines[k] for k in chosen]

    def quality(separator: str) -> tuple[float, int]:
        rows = _split(sample, separator)
        width, count = Counter(map(len, rows)).most_common(1)[0]
        cells = [cell for row in rows for cell in row if cell.strip()]
        numbers = sum(is_number(cell) for cell in cells) / max(1, len(cells))
        return (round(count / len(rows) * numbers, 2), width) if width > 1 else (0.0, 0)

    return max(_SEPARATORS, key=quality)


def _is_data(row: list[str], width: int) -> bool:
    if abs(len(row) - width) > 1:
        return False
    cells = [cell.strip() for cell in row]
    if all(cell.lower() in MISSING for cell in cells):
        return True
    numbers = sum(map(is_number, cells))
    # a line of metadata, "Rate,50,,", has as many words
    words = sum(cell.lower() not in MISSING and ":" not in cell for cell in cells) - numbers
    return numbers > max(0, words)


def _end_of_data(rows: list[list[str]], begin: int, width: int) -> int:
    """Find the first of the remarks below the data, such as a mean or a number of samples."""
    end = len(rows)
    words_first = sum(_is_remark(row) for row in rows[begin : begin + _SAMPLE]) > _SAMPLE // 2
    # from the end, since nearly all rows are data
    while end > begin and not words_first and _is_remark(rows[end - 1]):
        end -= 1
    last = next((k for k in range(end, 0, -1) if _is_data(rows[k - 1], width)), len(rows))
    while last < end and not _is_remark(rows[last]):
        last += 1
    return last


def _is_remark(row: list[str]) -> bool:
    """Tell a remark below the data from a line that was cut off."""
    return bool(re.match(r"[^\W\d_]{2}", row[0].strip())) and row[0].strip().lower() not in MISSING


def _header(
    path: Path,
    above: list[list[str]],
    comments: list[tuple[int, str]],
    width: int,
    separator: str,
) -> tuple[list[str], tuple[str, ...] | None]:
    """Find the names, and the row of units below them."""
    # one name fewer if the first column is an index, or if lines end in a separator
    fitting = [_cut(row, width) for row in above]
    fitting = [row for row in fitting if width - 1 <= len(row) <= width]
    units = None
    if len(fitting) > 1 and _are_units(fitting[-1]):
        units = tuple(cell.strip() for cell in fitting[-1])
        fitting = fitting[:-1]
    if len(fitting) > 1 and {cell.strip() for cell in fitting[-1]} - {""} <= _STAGES:
        stages = fitting.pop()
        fitting[-1] = ["_".join(filter(None, pair)) for pair in zip_longest(fitting[-1], stages)]
    if not fitting:
        # numpy and Matlab put the header behind a comment sign
        bare = [line.lstrip("#%/ \t") for _, line in comments]
        fitting = [row for row in _split(bare, separator) if len(row) == width]
    if not fitting:
        found = separator.join(above[-1])[:80] if above else "numbers"
        halves = bool(above) and len(above[-1]) == width / 2
        raise RecordingError(
            f"{path}: no header line with {width} names above the numbers; found {found}"
            + (f"; are both fields and decimals separated by '{separator}'?" if halves else "")
        )
    return [cell.strip().strip("\"'").strip() for cell in fitting[-1]], units


def _are_units(row: list[str]) -> bool:
    """Return whether at least half of the cells are units; unknown ones are reported later."""
    cells = [cell for cell in row if cell.strip().lower() not in ("", "-", "n/a", "unit", "units")]
    return 2 * sum(map(is_unit, cells)) >= max(1, len(cells))


def _cut(row: list[str], width: int) -> list[str]:
    """Remove empty cells beyond a width, from separators at the end of a line."""
    while len(row) > width and not row[-1].strip():
        row = row[:-1]
    return row


def _even(
    path: Path, rows: list[list[str]], line_numbers: list[int], n_names: int
) -> tuple[list[list[str]], bool]:
    """Trim all rows to the width of the header; return whether they start with an index."""
    longer = sum(any(cell.strip() for cell in row[n_names:]) for row in rows)
    has_index = longer > len(rows) // 2
    width = n_names + has_index
    even = [_cut(row, width) for row in rows]
    for row, line in zip(even, line_numbers, strict=True):
        if len(row) != width:
            hint = "cut off?" if len(row) < width else "decimals separated as fields are?"
            raise RecordingError(
                f"{path}: line {line} has {len(row)} values, expected {width} ({hint})"
            )
    return even, has_index
