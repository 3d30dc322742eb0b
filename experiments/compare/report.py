"""One HTML file with all runs: sortable and zoomable, works offline."""

import html
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pyarrow  # noqa: F401 - imported here, so that the command names the missing library
from itables import to_html_datatable
from itables.javascript import generate_init_offline_itables_html
from plotly.colors import qualitative
from plotly.offline import get_plotlyjs
from plotly.subplots import make_subplots

from narx.errors import UserError
from narx.files import atomic_path
from narx.kinematics.segment_angles import AXES

_COLOURS = qualitative.Dark24
# key of a part's class in a configuration
_CLASS = "._target_"
# more curves than this cannot be told apart
_MOST_CURVES = 60
_ANGLES: dict[str, Any] = {
    **dict.fromkeys(("trial", "segment", "axis", "method"), str),
    **dict.fromkeys(("time_s", "reference_deg", "estimate_deg"), float),
}
_HEAD = (
    '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Comparison of runs</title>'
    "<style>body{font-family:sans-serif;margin:2em;max-width:1200px}</style></head><body>"
)


def write_report(
    path: Path,
    table: pd.DataFrame,
    histories: Mapping[str, list[dict[str, Any]]],
    best: Path,
    metric: str,
    keys: Sequence[str],
    sentences: Sequence[str],
) -> None:
    """Write the report.

    Parameters
    ----------
    path : pathlib.Path
        File to write.
    table : pandas.DataFrame
        From `narx.experiments.compare.runs.runs_table`.
    histories : mapping of str to list of dict
        Iterations of each run, by its name in the table.
    best : pathlib.Path
        Folder of the best run, for its angles.
    metric : str
        Metric by which they are ranked.
    keys : sequence of str
        Keys that differ between runs.
    sentences : sequence of str
        Summary of the results.

    Raises
    ------
    UserError
        If the angles of the best run cannot be read.
    """
    figures = {
        "Settings against the error": settings_figure(table, metric, keys),
        "Each setting": scatter_figure(table, metric, keys),
        "Learning curves": learning_figure(table, histories),
        **angle_figures(best),
    }
    parts = [
        _HEAD,
        f"<h1>{len(table)} runs by {html.escape(metric)}</h1>",
        *(f"<p>{html.escape(sentence)}</p>" for sentence in sentences),
        generate_init_offline_itables_html(
            Path(str(resources.files("itables"))) / "html" / "dt_bundle.js"
        ),
        to_html_datatable(readable(table).round(4), connected=False, paging=False, maxBytes=0),
        f"<script>{get_plotlyjs()}</script>",
    ]
    for title, figure in figures.items():
        if figure is not None:
            parts.append(f"<h2>{html.escape(title)}</h2>")
            parts.append(figure.to_html(full_html=False, include_plotlyjs=False))
    with atomic_path(path) as temporary:
        temporary.write_text("\n".join([*parts, "</body></html>"]), encoding="utf-8")


def settings_figure(table: pd.DataFrame, metric: str, keys: Sequence[str]) -> go.Figure | None:
    """Draw parallel coordinates: each run is a line through its settings to its error.

    Parameters
    ----------
    table : pandas.DataFrame
        One row per run.
    metric : str
        Metric of the last axis and of the colour.
    keys : sequence of str
        The other axes.

    Returns
    -------
    plotly.graph_objects.Figure or None
        Parallel coordinates; None if nothing differs.
    """
    if not keys:
        return None
    dimensions = [_dimension(key, table[key]) for key in keys]
    dimensions.append({"label": metric, "values": table[metric]})
    lines = go.Parcoords(
        dimensions=dimensions,
        line={"color": table[metric], "colorscale": "Viridis_r", "showscale": True},
        labelangle=-20,
    )
    figure = go.Figure(lines)
    figure.update_layout(height=480, margin={"t": 140})
    return figure


def _dimension(key: str, values: pd.Series) -> dict[str, object]:
    numeric = pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values)
    if numeric and values.notna().all():
        return {"label": _label(key), "values": values}
    # a run whose part lacks the setting has no number to draw a line to, only a name
    ordered = values.sort_values(na_position="first") if numeric else values
    names = list(dict.fromkeys(ordered.map(_named)))
    if not numeric:
        names.sort()
    return {
        "label": _label(key),
        "values": values.map(_named).map(names.index),
        "tickvals": list(range(len(names))),
        "ticktext": names,
    }


def readable(table: pd.DataFrame) -> pd.DataFrame:
    """Name the parts that were chosen instead of the classes that implement them.

    Parameters
    ----------
    table : pandas.DataFrame
        Columns may be dotted keys of configurations.

    Returns
    -------
    pandas.DataFrame
        ``optimizer`` with ``LevenbergMarquardt`` instead of ``optimizer._target_`` with its path.
    """
    named = table.copy()
    for column in map(str, table):
        if column.endswith(_CLASS):
            named[column] = table[column].map(_named)
    return named.rename(columns=lambda key: key if _label(key) in table else _label(key))


def _label(key: str) -> str:
    return key.removesuffix(_CLASS)


def _named(value: object) -> str:
    if pd.isna(value):  # type: ignore[call-overload]
        return "–"
    # the last word of a class's path identifies it
    return str(value).rpartition(".")[2] if isinstance(value, str) else f"{value}"


def scatter_figure(table: pd.DataFrame, metric: str, keys: Sequence[str]) -> go.Figure | None:
    """Draw the error against each key that differs, one point per run.

    Parameters
    ----------
    table : pandas.DataFrame
        One row per run.
    metric : str
        Metric on the ordinate.
    keys : sequence of str
        Keys, one panel each.

    Returns
    -------
    plotly.graph_objects.Figure or None
        None if nothing differs.
    """
    if not keys:
        return None
    columns = min(len(keys), 3)
    rows = -(-len(keys) // columns)
    figure = make_subplots(
        rows, columns, subplot_titles=[_label(key) for key in keys], shared_yaxes=True
    )
    for i, key in enumerate(keys):
        values = table[key]
        if not pd.api.types.is_numeric_dtype(values) or pd.api.types.is_bool_dtype(values):
            values = values.map(_named)
        points = go.Scatter(
            x=values, y=table[metric], mode="markers", text=table["run"], showlegend=False,
            marker={"color": [_COLOURS[(r - 1) % len(_COLOURS)] for r in table["rank"]]},
        )  # fmt: skip
        figure.add_trace(points, row=i // columns + 1, col=i % columns + 1)
    figure.update_yaxes(title_text=metric, col=1)
    figure.update_layout(height=320 * rows)
    return figure


def learning_figure(
    table: pd.DataFrame, histories: Mapping[str, list[dict[str, Any]]]
) -> go.Figure | None:
    """Draw the cost by iteration of the best start of every run.

    Parameters
    ----------
    table : pandas.DataFrame
        One row per run, the best first.
    histories : mapping of str to list of dict
        Iterations of each run, by its name in the table.

    Returns
    -------
    plotly.graph_objects.Figure or None
        None if no run is a training.
    """
    figure = go.Figure()
    for row in table.head(_MOST_CURVES).itertuples():
        history = pd.DataFrame(histories[str(row.run)])
        if "cost_deg2" not in history:
            continue  # a benchmark, or written by another version
        colour = _COLOURS[(int(str(row.rank)) - 1) % len(_COLOURS)]
        figure.add_scatter(
            y=history["cost_deg2"],
            name=f"{row.rank}: {row.run}",
            mode="lines",
            line={"color": colour},
        )
    if not figure.data:
        return None
    figure.update_yaxes(type="log", title_text="cost (deg²)")
    figure.update_xaxes(title_text="iteration")
    return figure


def angle_figures(folder: Path) -> dict[str, go.Figure | None]:
    """Draw angles of a run beside the reference, and their differences (Bland and Altman).

    Parameters
    ----------
    folder : pathlib.Path
        Folder of the best run.

    Returns
    -------
    dict of str to plotly.graph_objects.Figure
        By heading; empty if the run stored no angles.

    Raises
    ------
    UserError
        If the file of the angles is damaged.
    """
    path = folder / "angles.csv"
    if not path.exists():
        return {}
    try:
        angles = pd.read_csv(path, dtype=_ANGLES, usecols=list(_ANGLES))
    except (OSError, ValueError) as damage:  # pandas' own are ValueErrors
        reason = " ".join(str(damage).split())
        raise UserError(f"{path}: not the angles of a run ({reason})") from damage
    angles = angles[angles["method"] == "narx"]
    if angles.empty:
        return {}
    first = angles[(angles["trial"] == angles["trial"].iloc[0])]
    first = first[first["segment"] == first["segment"].iloc[0]]
    waves = make_subplots(len(AXES), 1, shared_xaxes=True, subplot_titles=list(AXES))
    differences = make_subplots(1, len(AXES), subplot_titles=list(AXES))
    for k, axis in enumerate(AXES):
        piece, all_of_axis = first[first["axis"] == axis], angles[angles["axis"] == axis]
        for column, colour in (("reference_deg", "black"), ("estimate_deg", _COLOURS[0])):
            waves.add_scatter(
                x=piece["time_s"], y=piece[column], name=column, line={"color": colour},
                showlegend=k == 0, row=k + 1, col=1,
            )  # fmt: skip
        error = all_of_axis["reference_deg"] - all_of_axis["estimate_deg"]
        mean = (all_of_axis["reference_deg"] + all_of_axis["estimate_deg"]) / 2
        differences.add_scatter(
            x=mean, y=error, mode="markers", marker={"size": 3, "color": _COLOURS[k]},
            showlegend=False, row=1, col=k + 1,
        )  # fmt: skip
        bias, spread = float(error.mean()), float(error.std())
        if np.isfinite(spread):
            for level, dash in ((bias, "solid"), (bias - 1.96 * spread, "dash"),
                                (bias + 1.96 * spread, "dash")):  # fmt: skip
                differences.add_hline(level, line_dash=dash, row=1, col=k + 1)
    waves.update_layout(height=600)
    differences.update_yaxes(title_text="reference − estimate (°)", col=1)
    differences.update_xaxes(title_text="mean of both (°)")
    where = f"{first['trial'].iloc[0]}, {first['segment'].iloc[0]}"
    return {
        f"Angles of the best run in degrees: {where}": waves,
        "Differences of the best run, with mean and 95 % limits of agreement": differences,
    }
