"""The benchmark's page: every source, both blocks, all methods, by motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from narx.experiments.method_labels import BLOCKS, method_block, method_label, method_order
from narx.experiments.tables.subjects import condition_order
from narx.experiments.tables.table import Table, as_markdown
from narx.kinematics.segment_angles import AXES
from narx.recordings.trial import kind_of

NUMBERS = ("rmse_deg", "precision_deg", "r", "lag_ms")
KEYS = ("subject", "condition", "segment", "axis", "method")
QUANTITIES = {"rmse_deg": "RMSE", "precision_deg": "SD of the error"}


@dataclass(frozen=True)
class Source:
    """What one benchmark left, and how it is shown.

    Parameters
    ----------
    title : str
        Heading.
    command : str
        Makes the numbers.
    segment : str
        ``knee``, ``thigh``, ...: what the tables are of.
    quantity : {"rmse_deg", "precision_deg"}
        What is shown.
    means : pandas.DataFrame
        From `subject_condition_means`.
    not_causal : tuple of str
        Rows that look ahead.
    made : str
        Versions and commit.
    """

    title: str
    command: str
    segment: str
    quantity: str
    means: pd.DataFrame
    not_causal: tuple[str, ...]
    made: str


def subject_condition_means(results: pd.DataFrame) -> pd.DataFrame:
    """Average a benchmark's results over trials and sides.

    Parameters
    ----------
    results : pandas.DataFrame
        ``results.csv``.

    Returns
    -------
    pandas.DataFrame
        A row per subject, condition, kind of segment, axis and method: `KEYS`, ``n_trials`` and
        `NUMBERS`.
    """
    scored = results[results["n_samples"] > 0].assign(segment=results["segment"].map(kind_of))
    groups = scored.groupby(list(KEYS), sort=False)
    means = groups[list(NUMBERS)].mean()
    means.insert(0, "n_trials", groups["trial"].count())
    return means.reset_index()


def by_motion(source: Source, block: str) -> Table:
    """Print one block of a source.

    Parameters
    ----------
    source : Source
        The source.
    block : str
        One of `narx.experiments.method_labels.BLOCKS`.

    Returns
    -------
    Table
        A row per axis and method, a column per motion: means over subjects; then the mean over
        motions and the mean lag.
    """
    means = source.means[source.means["segment"] == source.segment]
    means = means[means["method"].map(method_block) == block]
    motions = condition_order(means["condition"].unique())
    rows = []
    for axis in AXES:
        here = means[means["axis"] == axis]
        for method in method_order(here["method"]):
            of_method = here[here["method"] == method]
            by_condition = of_method.groupby("condition")[[source.quantity, "lag_ms"]].mean()
            values = by_condition[source.quantity]
            rows.append(
                {
                    "Axis": axis,
                    "Method": method_label(method, source.not_causal),
                    **{motion: values.get(motion) for motion in motions},
                    "mean": values.mean(),
                    "lag (ms)": by_condition["lag_ms"].mean(),
                }
            )
    columns = ["Axis", "Method", *motions, "mean", "lag (ms)"]
    frame = pd.DataFrame(rows, columns=columns).set_index(["Axis", "Method"])
    decimals = dict.fromkeys((*motions, "mean"), 2) | {"lag (ms)": 0}
    title = f"{source.title}, {source.segment}, {block}: {QUANTITIES[source.quantity]} (degrees)"
    return Table(title, frame, decimals)


def benchmark_page(sources: Mapping[str, Source]) -> str:
    """Write the page.

    Parameters
    ----------
    sources : mapping of str to Source
        In the order wanted.

    Returns
    -------
    str
        Markdown.
    """
    parts = [
        "# The benchmark",
        "Made by `python -m experiments.benchmark_page`; nothing on this page is typed by hand. "
        "Two blocks: each method *as its paper prints it*, and each *with the same ingredients* "
        "that the network has (coupled axes, start-up, washout, a heading that leaks). *Chosen*: "
        "parameters chosen on the training part of each fold, as the network is trained there. "
        "*Not causal*: looks at samples that come later. Lag: how late the estimate comes, to "
        "first order. Means over subjects; trials and sides are averaged within a subject first.",
    ]
    for source in sources.values():
        parts += [f"## {source.title}", f"```\n{source.command}\n```", source.made]
        tables = [by_motion(source, block) for block in BLOCKS]
        parts.append(as_markdown(table for table in tables if len(table.frame)))
    return "\n\n".join(part.strip() for part in parts) + "\n"


def at_a_glance(sources: Mapping[str, Source], methods: Sequence[str]) -> str:
    """Write the table of the README: a few methods, all sources, means over motions.

    Parameters
    ----------
    sources : mapping of str to Source
        In the order wanted.
    methods : sequence of str
        Rows, as in ``results.csv``.

    Returns
    -------
    str
        Markdown table.
    """
    columns: dict[str, dict[str, float]] = {}
    for source in sources.values():
        means = source.means[source.means["segment"] == source.segment]
        over = means.groupby(["axis", "method", "condition"])[source.quantity].mean()
        for axis in AXES:
            if axis in over.index.get_level_values("axis"):
                values = over[axis].groupby("method").mean()
                if values.notna().any():
                    columns[f"{source.title}: {axis}"] = values.to_dict()
    rows = []
    ahead = {row for source in sources.values() for row in source.not_causal}
    for method in method_order(methods):
        values = {name: column.get(method) for name, column in columns.items()}
        label = method_label(method, ahead)
        rows.append({"": method_block(method), "Method": label} | values)
    frame = pd.DataFrame(rows).set_index(["", "Method"])
    table = Table("", frame, dict.fromkeys(columns, 2))
    return table.to_markdown().split("\n", 2)[2]
