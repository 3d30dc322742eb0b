"""Run the benchmarks of all sources and make docs/benchmark.md and README's table from them."""

import json
import re
import subprocess
import sys
import tempfile
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


def measure(cfg: DictConfig, name: str, folder: Path) -> None:
    """Run one source's benchmark and keep its means.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        Holds `sources`: overrides by name.
    name : str
        Which.
    folder : pathlib.Path
        Gets ``<name>.csv`` and ``<name>.json``.

    Raises
    ------
    UserError
        If the benchmark fails.
    """
    overrides = list(cfg.sources[name].overrides)
    with tempfile.TemporaryDirectory() as run:
        arguments = [*overrides, f"hydra.run.dir={run}"]
        if cfg.data_root is not None:
            arguments.append(f"data_root={cfg.data_root}")
        done = subprocess.run(
            [sys.executable, "-m", "narx.experiments.benchmark", *arguments],
            stdout=subprocess.PIPE,
            text=True,
        )
        if done.returncode:
            raise UserError(f"sources.{name}: its benchmark ended with status {done.returncode}")
        means = subject_condition_means(read_results(Path(run) / "results.csv"))
        environment = json.loads((Path(run) / "environment.json").read_text())
    with atomic_path(folder / f"{name}.csv") as temporary:
        means.to_csv(temporary, index=False, float_format="%.6g", lineterminator="\n")
    kept = ("git_commit", "seed", "python", "versions", "not_causal")
    write_json({key: environment[key] for key in kept}, folder / f"{name}.json")


def kept_sources(cfg: DictConfig, folder: Path) -> dict[str, Source]:
    """Read what `measure` has left.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        Holds `sources`.
    folder : pathlib.Path
        Where ``<name>.csv`` and ``<name>.json`` lie.

    Returns
    -------
    dict of str to Source
        Those that are there, in the order of the configuration.
    """
    sources = {}
    for name, shown in cfg.sources.items():
        table, about_file = folder / f"{name}.csv", folder / f"{name}.json"
        if not table.is_file():
            continue
        about = json.loads(about_file.read_text())
        versions = about["versions"]
        kept = ", ".join(f"{k} {versions[k]}" for k in ("torch", "numpy", "scipy", "numba"))
        sources[str(name)] = Source(
            shown.title,
            " ".join(["python -m experiments.benchmark", *shown.overrides]),
            shown.segment,
            shown.quantity,
            pd.read_csv(table, dtype={"subject": str, "condition": str}),
            tuple(about["not_causal"]),
            f"Commit {str(about['git_commit'])[:10]}, seed {about['seed']}, {kept}.",
        )
    return sources


def with_table(readme: str, table: str) -> str:
    """Put a table between the marks of a page.

    Parameters
    ----------
    readme : str
        Text with the marks `BEGIN` and `END`.
    table : str
        Markdown.

    Returns
    -------
    str
        The text with the table between its marks.

    Raises
    ------
    UserError
        If a mark is missing.
    """
    if BEGIN not in readme or END not in readme:
        raise UserError(f"README.md: expected the marks '{BEGIN}' and '{END}'")
    between = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END), re.DOTALL)
    return between.sub(lambda _: f"{BEGIN}\n{table.strip()}\n{END}", readme)


def _benchmark_page(cfg: DictConfig) -> None:
    root = Path(cfg.root)
    folder = root / "docs" / "results"
    names = list(cfg.sources) if cfg.only is None else list(cfg.only)
    if cfg.measure:
        folder.mkdir(parents=True, exist_ok=True)
        for name in tqdm(names, desc="benchmarks", disable=None):
            if name not in cfg.sources:
                raise UserError(f"only: no source '{name}', expected of {', '.join(cfg.sources)}")
            measure(cfg, name, folder)
    sources = kept_sources(cfg, folder)
    if not sources:
        raise UserError(f"{folder}: no results; run with measure=true")
    readme = root / "README.md"
    pages = {
        root / "docs" / "benchmark.md": benchmark_page(sources),
        readme: with_table(
            readme.read_text(),
            at_a_glance(
                {k: v for k, v in sources.items() if k in cfg.glance.sources}, cfg.glance.methods
            ),
        ),
    }
    for path, text in pages.items():
        with atomic_path(path) as temporary:
            temporary.write_text(text)
        print(path)


main = command("benchmark_page")(_benchmark_page)

if __name__ == "__main__":
    main()
