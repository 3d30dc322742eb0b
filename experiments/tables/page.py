"""The benchmark page: every source, both blocks, all methods, by motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from narx.evaluation.significance import paired_test
from narx.experiments.forms import CHOSEN
from narx.experiments.method_labels import BLOCKS, method_block, method_label, method_order
from narx.experiments.tables.as_printed import as_printed_table
from narx.experiments.tables.chosen import chosen_table
from narx.experiments.tables.subjects import condition_order
from narx.experiments.tables.table import Table, as_markdown
from narx.kinematics.segment_angles import AXES
from narx.recordings.trial import kind_of

NUMBERS = ("rmse_deg", "precision_deg", "r", "lag_ms")
KEYS = ("subject", "condition", "segment", "axis", "method")
# with fewer, no paired permutation has a p below 0.06
_SUBJECTS_FOR_A_TEST = 6
QUANTITIES = {"rmse_deg": "RMSE", "precision_deg": "SD of the error"}


@dataclass(frozen=True)
class Source:
    """The results of one benchmark, and how they are presented.

    Parameters
    ----------
    title : str
        Heading.
    command : str
        Command that reproduces the results.
    segment : str
        Segment or joint of the tables: ``knee``, ``thigh``, ...
    quantity : {"rmse_deg", "precision_deg"}
        Quantity of the tables.
    means : pandas.DataFrame
        From `subject_condition_means`.
    not_causal : tuple of str
        Rows that use later samples.
    made : str
        Versions and commit.
    chosen : mapping of tuple of str to mapping
        Parameters chosen, by fold and row.
    us_per_sample : mapping of str to float
        CPU time of each row.
    figures : mapping of str to str
        Caption by file name in ``docs/figures``.
    """

    title: str
    command: str
    segment: str
    quantity: str
    means: pd.DataFrame
    not_causal: tuple[str, ...]
    made: str
    chosen: Mapping[tuple[str, str], Mapping[str, Any]] = field(default_factory=dict)
    us_per_sample: Mapping[str, float] = field(default_factory=dict)
    figures: Mapping[str, str] = field(default_factory=dict)


def subject_condition_means(results: pd.DataFrame) -> pd.DataFrame:
    """Average a benchmark's results over trials and sides.

    Parameters
    ----------
    results : pandas.DataFrame
        ``results.csv``.

    Returns
    -------
    pandas.DataFrame
        One row per subject, condition, kind of segment, axis and method: `KEYS`, ``n_trials`` and
        `NUMBERS`.
    """
    scored = results[results["n_samples"] > 0].assign(segment=results["segment"].map(kind_of))
    groups = scored.groupby(list(KEYS), sort=False)
    means = groups[list(NUMBERS)].mean()
    means.insert(0, "n_trials", groups["trial"].count())
    return means.reset_index()


def by_motion(source: Source, block: str) -> Table:
    """Tabulate one block of a source.

    Parameters
    ----------
    source : Source
        The source.
    block : str
        One of `narx.experiments.method_labels.BLOCKS`.

    Returns
    -------
    Table
        One row per axis and method, one column per motion with means over subjects; then the mean
        over motions and the mean lag.
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


def against_network(source: Source) -> Table | None:
    """Compare every row with NARX over the subjects.

    Parameters
    ----------
    source : Source
        The source.

    Returns
    -------
    Table or None
        Row less NARX with a 95 % interval and p; None for few subjects or without NARX.
    """
    means = source.means[source.means["segment"] == source.segment]
    if means["subject"].nunique() < _SUBJECTS_FOR_A_TEST or "narx" not in set(means["method"]):
        return None
    of_subjects = means.groupby(["axis", "method", "subject"])[source.quantity].mean()
    rows = []
    for axis in AXES:
        table = of_subjects[axis].unstack("method")
        for method in method_order(set(table) - {"narx"}):
            both = table[[method, "narx"]].dropna()
            if both.empty:
                continue
            better = int((both[method] < both["narx"]).sum())
            test = paired_test(both[method].to_numpy(), both["narx"].to_numpy())
            rows.append(
                {
                    "Axis": axis,
                    "Block": method_block(method),
                    "Method": method_label(method, source.not_causal),
                    "less NARX": test.difference,
                    "95 % interval": f"{test.low:.2f} to {test.high:.2f}",
                    "p": test.p_permutation,
                    "better than NARX": f"{better} of {len(both)}",
                }
            )
    quantity = QUANTITIES[source.quantity]
    return Table(
        f"{source.title}, {source.segment}: difference from NARX in {quantity} (degrees)",
        pd.DataFrame(rows).set_index(["Axis", "Block", "Method"]),
        {"less NARX": 2, "p": 4},
        "Negative: the row is better than NARX. Mean over motions within a subject, then over "
        "subjects; bootstrap interval, p of random exchanges, not corrected for the number of "
        "rows.",
    )


def cost_table(source: Source) -> Table:
    """Print the CPU time of every method.

    Parameters
    ----------
    source : Source
        The source on which it was measured.

    Returns
    -------
    Table
        A row per method as printed, with the network's parts, and the network.
    """
    methods = [row for row in method_order(source.us_per_sample) if not row.endswith(CHOSEN)]
    frame = pd.DataFrame(
        {
            "Block": [method_block(row) for row in methods],
            "Method": [method_label(row, source.not_causal) for row in methods],
            "µs per sample": [source.us_per_sample[row] for row in methods],
        }
    ).set_index(["Block", "Method"])
    return Table(
        "CPU time for the three angles of one sample, whole recordings",
        frame,
        {"µs per sample": 2},
        "Of one core, on the machine that made this page. A filter runs once for all treatments of "
        "its heading: its rows with heading 0 or leak are what these add.",
    )


def benchmark_page(
    sources: Mapping[str, Source],
    as_printed: tuple[pd.DataFrame, str] | None = None,
    missing: Sequence[str] = (),
) -> str:
    """Write the page.

    Parameters
    ----------
    sources : mapping of str to Source
        In the order wanted.
    as_printed : tuple of pandas.DataFrame and str, optional
        Results of ``experiments.as_printed`` and the command; None leaves the section out.
    missing : sequence of str
        Titles of sources of which no results are kept.

    Returns
    -------
    str
        Markdown.
    """
    parts = [
        "# The benchmark",
        "Made by `python -m experiments.benchmark_page`; nothing on this page is typed by hand. "
        "Two blocks: each method *as its paper prints it*, and each *with the same ingredients* "
        "that the network has: coupled axes and the tracker of posture and bias for integrators, "
        "which can take the network's place in it (beside them what they do with a start-up and a "
        "washout instead); coupled axes, start-up and washout for the other recursions; a heading "
        "that leaks towards the start-up's for filters with an accelerometer. *Chosen*: "
        "parameters chosen on the training part of each fold, as the network is trained there. "
        "*Not causal*: looks at samples that come later. Lag: how late the estimate "
        "comes, to first order; a phase error counts as one. Means over subjects; trials and sides "
        "are averaged within a subject first.",
    ]
    if missing:
        parts.append(f"No results are kept yet of: {'; '.join(missing)}.")
    for source in sources.values():
        parts += [f"## {source.title}", f"```\n{source.command}\n```", source.made]
        tables = [by_motion(source, block) for block in BLOCKS]
        tables = [table for table in tables if len(table.frame)]
        tables += [t for t in (against_network(source), chosen_table(source.chosen)) if t]
        parts.append(as_markdown(tables))
        parts += [f"![{caption}](figures/{name})" for name, caption in source.figures.items()]
    timed = next((source for source in sources.values() if source.us_per_sample), None)
    if timed is not None:
        parts += ["## Cost", f"On: {timed.title}.", cost_table(timed).to_markdown()]
    if as_printed is not None:
        results, command = as_printed
        parts += ["## Tham et al., trained as printed", f"```\n{command}\n```"]
        parts.append(as_printed_table(results).to_markdown())
    return "\n\n".join(part.strip() for part in parts) + "\n"
