"""The part of the README that is made from the benchmark: a table, and what it shows in words."""

from collections.abc import Mapping, Sequence

import pandas as pd

from narx.experiments.method_labels import method_block, method_label, method_order
from narx.experiments.tables.page import QUANTITIES, Source
from narx.experiments.tables.table import Table
from narx.kinematics.segment_angles import AXES

# what is said, of which two rows of ``results.csv``, and what stands between their errors
_SAID = (
    (
        "**Coupled axes and a start-up** change the error of the leaky integrator (one parameter)",
        ("leaky_integrator_chosen", "leaky_integrator_start_up_chosen"),
        "to",
    ),
    (
        "**The tracker** instead of the start-up changes it",
        ("leaky_integrator_start_up_chosen", "leaky_integrator_same_chosen"),
        "to",
    ),
    (
        "**The network** in the integrator's place changes that",
        ("leaky_integrator_same_chosen", "narx"),
        "to",
    ),
    (
        "**VQF with an accelerometer**, chosen, and NARX without one",
        ("vqf_same_chosen", "narx"),
        "and",
    ),
    (
        "**Without any filter**, the start-up's posture held constant (it looks ahead), and NARX",
        ("constant", "narx"),
        "and",
    ),
)


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
        Markdown table; empty without a source.
    """
    if not sources:
        return ""
    columns: dict[str, dict[str, float]] = {}
    for source in sources.values():
        means = source.means[source.means["segment"] == source.segment]
        over = means.groupby(["axis", "method", "condition"])[source.quantity].mean()
        for axis in AXES:
            if axis in over.index.get_level_values("axis"):
                values = over[axis].groupby("method").mean()
                if values.notna().any():
                    what = f"{source.segment} {QUANTITIES[source.quantity]}, {axis}"
                    columns[f"{source.title}: {what}"] = values.to_dict()
    rows = []
    ahead = {row for source in sources.values() for row in source.not_causal}
    for method in method_order(methods):
        values = {name: column.get(method) for name, column in columns.items()}
        label = method_label(method, ahead)
        rows.append({"": method_block(method), "Method": label} | values)
    frame = pd.DataFrame(rows).set_index(["", "Method"])
    table = Table("", frame, dict.fromkeys(columns, 2))
    return table.to_markdown().split("\n", 2)[2].strip()


def in_words(
    sources: Mapping[str, Source], names: Mapping[str, str], draws: pd.DataFrame | None
) -> str:
    """Say what the table shows.

    Parameters
    ----------
    sources : mapping of str to Source
        Of the table.
    names : mapping of str to str
        What the sentences call each source.
    draws : pandas.DataFrame, optional
        Results of ``experiments.as_printed``.

    Returns
    -------
    str
        Markdown list; a sentence whose rows are missing is left out.
    """
    lines = [_pairs(sources, names, *said) for said in _SAID]
    if draws is not None:
        printed = draws[draws["variant"] == draws["variant"].iloc[0]]["knee_sagittal_deg"]
        low, middle, high = printed.quantile([0.25, 0.5, 0.75])
        lines.append(
            "**Trained as Tham et al. print it**, knee, sagittal, normal speed, over "
            f"{len(printed)} draws: median {middle:.1f}°, quartiles {low:.1f} and {high:.1f}."
        )
    return "\n".join(f"- {line}" for line in lines if line)


def _pairs(
    sources: Mapping[str, Source],
    names: Mapping[str, str],
    what: str,
    rows: tuple[str, str],
    between: str,
) -> str:
    parts = []
    for name, source in sources.items():
        pairs = []
        for axis in AXES:
            first, second = (_by_motion(source, axis, row) for row in rows)
            if len(first) and len(second):
                pairs.append(f"{axis} {first.mean():.2f} {between} {second.mean():.2f}")
        if pairs:
            parts.append(f"{names[name]} {', '.join(pairs)}")
    return f"{what}: {'; '.join(parts)}." if parts else ""


def _by_motion(source: Source, axis: str, row: str) -> pd.Series:
    """Mean of each motion over subjects, of the shown kind of segment."""
    means = source.means
    here = means[(means["segment"] == source.segment) & (means["axis"] == axis)]
    here = here[here["method"] == row]
    return here.groupby("condition")[source.quantity].mean().dropna()
