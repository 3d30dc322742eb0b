"""A table with its title, as numbers until it is printed."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

MISSING = "–"


def shown(value: object, decimals: int) -> str:
    """Format one cell.

    Parameters
    ----------
    value : object
        Number, text, boolean or None.
    decimals : int
        Decimals of a number of floating type.

    Returns
    -------
    str
        A missing number is a dash.
    """
    if isinstance(value, str):
        return value
    if value is None or value is pd.NA or (isinstance(value, float) and np.isnan(value)):
        return MISSING
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, np.integer)):
        return str(value)
    # no "-0.0"
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"  # type: ignore[arg-type]


@dataclass(frozen=True)
class Table:
    """Numbers under a title.

    Parameters
    ----------
    title : str
        One line: what is shown, in which unit.
    frame : pandas.DataFrame
        Numbers or text; the index, if it has names, becomes the first columns.
    decimals : mapping of str to int
        Decimals by column; one if a column is not listed.
    note : str
        Text below the table.
    """

    title: str
    frame: pd.DataFrame
    decimals: Mapping[str, int] = field(default_factory=dict)
    note: str = ""

    def cells(self) -> pd.DataFrame:
        """Format every number.

        Returns
        -------
        pandas.DataFrame
            Text, without an index; a missing number is a dash, an index that repeats is blank.
        """
        frame = self.frame
        named = [name for name in frame.index.names if name is not None]
        if named:
            frame = frame.reset_index()
        text = pd.DataFrame(
            {
                column: [shown(value, self.decimals.get(str(column), 1)) for value in values]
                for column, values in frame.items()
            },
            columns=frame.columns,
            dtype=object,
        )
        # a level is repeated only if all levels before it are
        repeated = np.ones(len(text), dtype=bool)
        for column in named[:-1]:
            repeated &= (text[column] == text[column].shift()).to_numpy()
            text.loc[repeated, column] = ""
        return text

    def to_markdown(self) -> str:
        """Write the table as GitHub markdown, columns aligned so that it also reads as text.

        Returns
        -------
        str
            Title, table and note; ends with a newline.
        """
        text = self.cells()
        numeric = [
            text[column].str.fullmatch(rf"-?[\d.]+(e-?\d+)?|inf|-inf|{MISSING}|").all()
            for column in text.columns
        ]
        rows = [[str(column) for column in text.columns], *text.to_numpy().tolist()]
        rows = [[cell.replace("|", "\\|") for cell in row] for row in rows]
        widths = [max(3, *(len(row[k]) for row in rows)) for k in range(len(text.columns))]

        def line(row: list[str]) -> str:
            cells = (
                cell.rjust(width) if right else cell.ljust(width)
                for cell, width, right in zip(row, widths, numeric, strict=True)
            )
            return "| " + " | ".join(cells) + " |"

        ruler = [
            "-" * (width - 1) + ":" if right else "-" * width
            for width, right in zip(widths, numeric, strict=True)
        ]
        lines = [f"**{self.title}**", "", line(rows[0]), "| " + " | ".join(ruler) + " |"]
        lines += [line(row) for row in rows[1:]]
        if self.note:
            lines += ["", self.note]
        return "\n".join(lines) + "\n"

    def to_latex(self) -> str:
        """Write the table for LaTeX (packages booktabs; jinja2 has to be installed).

        Returns
        -------
        str
            A ``table`` environment with the title as caption.
        """
        return self.cells().to_latex(index=False, caption=self.title, escape=True)

    def to_csv(self) -> str:
        """Write the table's numbers with all their digits.

        Returns
        -------
        str
            CSV with a header.
        """
        named = any(name is not None for name in self.frame.index.names)
        return self.frame.to_csv(index=named, lineterminator="\n")


def as_markdown(tables: Iterable[Table]) -> str:
    """Write several tables.

    Parameters
    ----------
    tables : iterable of Table
        Tables in order.

    Returns
    -------
    str
        Markdown.
    """
    return "\n".join(table.to_markdown() for table in tables)
