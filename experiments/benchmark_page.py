"""Run the benchmarks of all sources and make docs/benchmark.md and README's table from them."""

import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from omegaconf import DictConfig
from tqdm import tqdm

from narx.errors import UserError
from narx.evaluation.results import read_results
from narx.experiments.command import command
from narx.experiments.runs.record import write_json
from narx.experiments.tables.page import (
    Source,
    at_a_glance,
    benchmark_page,
    subject_condition_means,
)
from narx.files import atomic_path

BEGIN, END = "<!-- benchmark -->", "<!-- end of benchmark -->"
AS_PRINTED = "as_printed"
_KEPT = ("git_commit", "seed", "python", "versions", "not_causal")


def measure(cfg: DictConfig, name: str, docs: Path) -> None:
    """Run the benchmark of one source and store its means and figures.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With `sources`: overrides by name.
    name : str
        Source to run.
    docs : pathlib.Path
        Folder for ``results/<name>.csv``, ``results/<name>.json`` and the figures.

    Raises
    ------
    UserError
        If the benchmark fails.
    """
    source = cfg.sources[name]
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder)
        overrides = list(source.overrides)
        if cfg.data_root is not None:
            overrides.append(f"data_root={cfg.data_root}")
        _run("benchmark", overrides, run, f"sources.{name}")
        means = subject_condition_means(read_results(run / "results.csv"))
        environment = json.loads((run / "environment.json").read_text())
        about = {key: environment[key] for key in _KEPT}
        about["chosen"] = json.loads((run / "chosen.json").read_text())
        timing = json.loads((run / "timing.json").read_text())
        about["us_per_sample"] = {k: round(v, 3) for k, v in timing["us_per_sample"].items()}
        for figure in source.figures:
            drawn = run / "figures" / f"{figure}.png"
            if not drawn.is_file():
                raise UserError(f"sources.{name}.figures: the benchmark drew no '{figure}'")
            (docs / "figures").mkdir(exist_ok=True)
            with atomic_path(docs / "figures" / _figure_name(name, figure)) as temporary:
                shutil.copyfile(drawn, temporary)
    with atomic_path(docs / "results" / f"{name}.csv") as temporary:
        means.to_csv(temporary, index=False, float_format="%.6g", lineterminator="\n")
    write_json(about, docs / "results" / f"{name}.json")


def measure_as_printed(cfg: DictConfig, docs: Path) -> None:
    """Run the training as printed and store its draws.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With `as_printed`: overrides.
    docs : pathlib.Path
        Folder for ``results/as_printed.csv``.

    Raises
    ------
    UserError
        If the command fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder)
        _run(AS_PRINTED, cfg.as_printed, run, AS_PRINTED)
        with atomic_path(docs / "results" / f"{AS_PRINTED}.csv") as temporary:
            shutil.copyfile(run / "as_printed.csv", temporary)


def _run(name: str, overrides: Sequence[str], run: Path, what: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", f"narx.experiments.{name}", *overrides, f"hydra.run.dir={run}"],
        stdout=subprocess.PIPE,
        text=True,
    )
    if done.returncode:
        raise UserError(f"{what}: the command ended with status {done.returncode}")


def _figure_name(source: str, figure: str) -> str:
    return f"benchmark_{source}_{figure}.png"


def kept_sources(cfg: DictConfig, docs: Path) -> dict[str, Source]:
    """Read the results stored by `measure`.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With `sources`.
    docs : pathlib.Path
        Folder with ``results/<name>.csv`` and ``results/<name>.json``.

    Returns
    -------
    dict of str to Source
        Sources with stored results, in the order of the configuration.
    """
    sources = {}
    for name, shown in cfg.sources.items():
        table, about_file = (docs / "results" / f"{name}.{end}" for end in ("csv", "json"))
        if not table.is_file():
            continue
        about = json.loads(about_file.read_text())
        versions = about["versions"]
        kept = ", ".join(f"{k} {versions[k]}" for k in ("torch", "numpy", "scipy", "numba"))
        sources[str(name)] = Source(
            shown.title,
            " ".join(["python -m experiments.benchmark", *map(_quoted, shown.overrides)]),
            shown.segment,
            shown.quantity,
            pd.read_csv(table, dtype={"subject": str, "condition": str}),
            tuple(about["not_causal"]),
            f"Commit {str(about['git_commit'])[:10]}, seed {about['seed']}, {kept}.",
            {
                (fold, row): values
                for fold, rows in about["chosen"].items()
                for row, values in rows.items()
            },
            about["us_per_sample"],
            {_figure_name(str(name), figure): text for figure, text in shown.figures.items()},
        )
    return sources


def _quoted(override: str) -> str:
    return f"'{override}'" if set(override) & set("[]{}, ") else override


def pages(cfg: DictConfig, root: Path) -> dict[Path, str]:
    """Write the pages from the stored results.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/benchmark_page.yaml``.
    root : pathlib.Path
        The checkout.

    Returns
    -------
    dict of pathlib.Path to str
        Text of ``docs/benchmark.md``, and of ``README.md`` with its table.

    Raises
    ------
    UserError
        If there are no results, or the README has no markers.
    """
    docs = root / "docs"
    sources = kept_sources(cfg, docs)
    if not sources:
        raise UserError(f"{docs / 'results'}: no results; run with measure=true")
    printed = docs / "results" / f"{AS_PRINTED}.csv"
    as_printed = None
    if printed.is_file():
        made = " ".join(["python -m experiments.as_printed", *map(_quoted, cfg.as_printed)])
        as_printed = pd.read_csv(printed), made
    glance = {name: sources[name] for name in cfg.glance.sources if name in sources}
    readme = root / "README.md"
    return {
        docs / "benchmark.md": benchmark_page(sources, as_printed),
        readme: with_table(readme.read_text(), at_a_glance(glance, cfg.glance.methods)),
    }


def with_table(readme: str, table: str) -> str:
    """Put a table between the markers of a page.

    Parameters
    ----------
    readme : str
        Text with the markers `BEGIN` and `END`.
    table : str
        Markdown.

    Returns
    -------
    str
        The text with the table between its markers.

    Raises
    ------
    UserError
        If a marker is missing.
    """
    if BEGIN not in readme or END not in readme:
        raise UserError(f"README.md: expected the markers '{BEGIN}' and '{END}'")
    between = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END), re.DOTALL)
    return between.sub(lambda _: f"{BEGIN}\n{table.strip()}\n{END}", readme)


def _benchmark_page(cfg: DictConfig) -> None:
    root = Path(cfg.root)
    known = [*map(str, cfg.sources), AS_PRINTED]
    names = known if cfg.only is None else list(cfg.only)
    for name in names:
        if name not in known:
            raise UserError(f"only: no source '{name}', expected one of {', '.join(known)}")
    if cfg.measure:
        (root / "docs" / "results").mkdir(parents=True, exist_ok=True)
        for name in tqdm(names, desc="benchmarks", disable=None):
            if name == AS_PRINTED:
                measure_as_printed(cfg, root / "docs")
            else:
                measure(cfg, name, root / "docs")
    for path, text in pages(cfg, root).items():
        with atomic_path(path) as temporary:
            temporary.write_text(text)
        print(path)


main = command("benchmark_page")(_benchmark_page)

if __name__ == "__main__":
    main()
