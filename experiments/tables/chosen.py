"""Table of the parameters chosen on the training part of each fold."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from narx.experiments.method_labels import method_label, method_order
from narx.experiments.tables.table import Table


def chosen_table(chosen: Mapping[tuple[str, str], Mapping[str, Any]]) -> Table | None:
    """List the chosen parameters.

    Parameters
    ----------
    chosen : mapping of tuple of str to mapping
        Values by parameter, by fold and row of the results.

    Returns
    -------
    Table or None
        One row per method, one column per fold; None if nothing was chosen.
    """
    if not chosen:
        return None
    folds = list(dict.fromkeys(fold for fold, _ in chosen))
    rows = []
    for row in method_order({row for _, row in chosen}):
        cells: dict[str, object] = {"Method": method_label(row)}
        for fold in folds:
            values = chosen.get((fold, row), {})
            cells[fold] = ", ".join(f"{name} {value:g}" for name, value in values.items())
        rows.append(cells)
    return Table(
        "Parameters chosen on the training part of each fold",
        pd.DataFrame(rows).set_index("Method"),
        note="Chosen from the grids in `configs/method` by the error minimised in training.",
    )
