"""Write the output of a report: summary.md, figures, TensorBoard."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure
from omegaconf import DictConfig

from narx.evaluation.trial import Refusal
from narx.experiments.figures.canvas import save_figure
from narx.experiments.gathered import Gathered
from narx.experiments.reports.networks import about_network, training_history_figure
from narx.experiments.reports.report import Report, Section
from narx.experiments.runs.record import write_json
from narx.experiments.tables.comparison import QUANTITIES
from narx.experiments.tables.overview import overview_table
from narx.experiments.tensorboard_log import TensorBoardLog
from narx.files import atomic_path, safe_name

# the numbers in a reason differ between trials; the first few reasons suffice
_REASONS_SHOWN = 8


def write_report(
    report: Report, cfg: DictConfig, gathered: Gathered, directory: Path, log: TensorBoardLog
) -> str:
    """Write tables, text and figures.

    Parameters
    ----------
    report : Report
        Report that has observed all trials.
    cfg : omegaconf.DictConfig
        The benchmark's configuration.
    gathered : Gathered
        Its results.
    directory : pathlib.Path
        Run directory.
    log : TensorBoardLog
        Receives figures and RMSE.

    Returns
    -------
    str
        The start of ``summary.md``: one table per metric, the networks, and what was left out.

    Raises
    ------
    UserError
        If the results lack the data for the report's tables.
    """
    start: list[Section] = [_heading(gathered)]
    start += [
        overview_table(gathered.results, quantity, gathered.not_causal) for quantity in QUANTITIES
    ]
    start += [about_network(fold, network) for fold, network in gathered.networks.items()]
    start += about_refusals(gathered.refusals)
    with atomic_path(directory / "summary.md") as temporary:
        temporary.write_text(_as_text([*start, *report.sections(cfg, gathered)]) + "\n")
    figures = report.figures(cfg, gathered)
    for fold, network in gathered.networks.items():
        if "report" in network.history:
            figures[f"training_{fold}"] = training_history_figure(network, fold)
    write_json(log.results(gathered.results), directory / "metrics.json")
    for name, path in save_figures(figures, directory).items():
        log.figure(name, path)
    return _as_text(start)


def _as_text(sections: Iterable[Section]) -> str:
    return "\n\n".join(
        section if isinstance(section, str) else section.to_markdown().strip()
        for section in sections
    )


def save_figures(figures: Mapping[str, Figure], directory: Path) -> dict[str, Path]:
    """Write figures into the folder ``figures`` of a run.

    Parameters
    ----------
    figures : mapping of str to matplotlib.figure.Figure
        By name, which may contain names from recordings.
    directory : pathlib.Path
        Run directory.

    Returns
    -------
    dict of str to pathlib.Path
        Files, by name.
    """
    paths = {}
    for name, figure in figures.items():
        paths[name] = directory / "figures" / f"{safe_name(name, 120)}.png"
        save_figure(figure, paths[name])
    return paths


def _heading(gathered: Gathered) -> str:
    results = gathered.results
    n_trials = len(results[["dataset", "subject", "condition", "trial"]].drop_duplicates())
    datasets = ", ".join(sorted(set(results["dataset"])))
    return f"# {datasets}: {n_trials} trial{'s' * (n_trials != 1)}"


def about_refusals(refusals: Sequence[Refusal]) -> list[str]:
    """List the methods that were not applicable to recordings.

    Parameters
    ----------
    refusals : sequence of Refusal
        Any number.

    Returns
    -------
    list of str
        One paragraph with one line per method and reason, or none.
    """
    if not refusals:
        return []
    counted = Counter((refusal.method, refusal.reason) for refusal in refusals)
    lines = [
        f"- {method}, {count} {'time' if count == 1 else 'times'}: {reason}"
        for (method, reason), count in counted.most_common(_REASONS_SHOWN)
    ]
    if len(counted) > len(lines):
        lines.append(f"- and {len(counted) - len(lines)} other reasons")
    return ["Left out:\n\n" + "\n".join(lines)]
