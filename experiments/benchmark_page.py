"""Run the benchmarks of all sources and make docs/benchmark.md and README's table from them."""

import json
import re
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from hydra.utils import instantiate
from omegaconf import DictConfig
from tqdm import tqdm

from narx.errors import UserError
from narx.experiments import as_printed, benchmark
from narx.experiments.command import command
from narx.experiments.configuration import composed_configuration
from narx.experiments.figures.canvas import save_figure
from narx.experiments.runs.record import environment, seed_everything, write_json
from narx.experiments.tables.glance import at_a_glance, in_words
from narx.experiments.tables.page import Source, benchmark_page, subject_condition_means
from narx.files import atomic_path

BEGIN, END = "<!-- benchmark -->", "<!-- end of benchmark -->"
AS_PRINTED = "as_printed"
_KEPT = ("git_commit", "seed", "python", "versions")


def measure(cfg: DictConfig, name: str, benchmark_cfg: DictConfig, docs: Path) -> None:
    """Run one source's benchmark and keep its means and figures.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        Holds `sources`: figures by name.
    name : str
        Which.
    benchmark_cfg : omegaconf.DictConfig
        Configuration of its benchmark.
    docs : pathlib.Path
        Gets ``results/<name>.csv``, ``results/<name>.json`` and the figures.

    Raises
    ------
    UserError
        If nothing can be scored, or a figure is not one of the report's.
    """
    seed_everything(benchmark_cfg.seed)
    report = instantiate(benchmark_cfg.report, _convert_="all")
    gathered = benchmark.run(benchmark_cfg, report=report)
    environment_of_run = environment(benchmark_cfg.seed, gathered.sources)
    about = {key: environment_of_run[key] for key in _KEPT}
    about["not_causal"] = sorted(gathered.not_causal)
    about["chosen"] = benchmark.by_fold(gathered.chosen)
    about["us_per_sample"] = {
        row: round(value, 3) for row, value in gathered.workload.us_per_sample.items()
    }
    wanted = cfg.sources[name].figures
    figures = report.figures(benchmark_cfg, gathered) if wanted else {}
    for figure in wanted:
        if figure not in figures:
            drawn = ", ".join(figures)
            raise UserError(f"sources.{name}.figures: no figure '{figure}', expected of {drawn}")
        save_figure(figures[figure], docs / "figures" / _figure_name(name, figure))
    means = subject_condition_means(gathered.results)
    with atomic_path(docs / "results" / f"{name}.csv") as temporary:
        means.to_csv(temporary, index=False, float_format="%.6g", lineterminator="\n")
    write_json(about, docs / "results" / f"{name}.json")


def _figure_name(source: str, figure: str) -> str:
    return f"benchmark_{source}_{figure}.png"


def kept_sources(cfg: DictConfig, docs: Path) -> dict[str, Source]:
    """Read what `measure` has left.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        Holds `sources`.
    docs : pathlib.Path
        Where ``results/<name>.csv`` and ``results/<name>.json`` lie.

    Returns
    -------
    dict of str to Source
        Those that are there, in the order of the configuration.
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
    """Write the pages from the kept results.

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
        If there are no results, or README has no markers.
    """
    docs = root / "docs"
    sources = kept_sources(cfg, docs)
    printed = docs / "results" / f"{AS_PRINTED}.csv"
    draws = None
    if printed.is_file():
        made = " ".join(["python -m experiments.as_printed", *map(_quoted, cfg.as_printed)])
        draws = pd.read_csv(printed), made
    if not sources and draws is None:
        raise UserError(f"{docs / 'results'}: no results; run with measure=true")
    missing = [shown.title for name, shown in cfg.sources.items() if name not in sources]
    glance = {name: sources[name] for name in cfg.glance.sources if name in sources}
    parts = [
        at_a_glance(glance, cfg.glance.methods),
        in_words(glance, cfg.glance.sources, None if draws is None else draws[0]),
    ]
    if cfg.glance.figures in sources:
        figures = sources[cfg.glance.figures].figures
        parts += [f"![{caption}](docs/figures/{name})" for name, caption in figures.items()]
    readme = root / "README.md"
    return {
        docs / "benchmark.md": benchmark_page(sources, draws, missing),
        readme: with_part(readme.read_text(), "\n\n".join(part for part in parts if part)),
    }


def with_part(readme: str, part: str) -> str:
    """Put what is made from results between the markers of a page.

    Parameters
    ----------
    readme : str
        Text with the markers `BEGIN` and `END`.
    part : str
        Markdown.

    Returns
    -------
    str
        The text with the part between its markers.

    Raises
    ------
    UserError
        If a marker is missing.
    """
    if BEGIN not in readme or END not in readme:
        raise UserError(f"README.md: expected the markers '{BEGIN}' and '{END}'")
    between = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END), re.DOTALL)
    return between.sub(lambda _: f"{BEGIN}\n{part.strip()}\n{END}", readme)


def _measure_all(cfg: DictConfig, names: Sequence[str], docs: Path) -> list[str]:
    """Measure one source after the other; return why some could not be."""
    common = [] if cfg.data_root is None else [f"data_root={cfg.data_root}"]
    # all are checked before the first runs
    configurations = {
        name: composed_configuration("benchmark", [*common, *source.overrides], f"sources.{name}")
        for name, source in cfg.sources.items()
        if name in names
    }
    printed = composed_configuration(AS_PRINTED, cfg.as_printed, AS_PRINTED)
    (docs / "results").mkdir(parents=True, exist_ok=True)
    failures = []
    for name in tqdm(names, desc="benchmarks", disable=None):
        try:
            if name == AS_PRINTED:
                seed_everything(printed.seed)
                as_printed.write_draws(as_printed.run(printed), docs / "results" / f"{name}.csv")
            else:
                measure(cfg, name, configurations[name], docs)
        except UserError as error:  # the other sources are not to be lost
            failures.append(f"{name}: {error}")
    return failures


def _benchmark_page(cfg: DictConfig) -> None:
    root = Path(cfg.root)
    known = [*map(str, cfg.sources), AS_PRINTED]
    names = known if cfg.only is None else list(cfg.only)
    for name in names:
        if name not in known:
            raise UserError(f"only: no source '{name}', expected one of {', '.join(known)}")
    readme = root / "README.md"
    with_part(readme.read_text(), "")  # refuses a page without markers before anything is run
    failures = _measure_all(cfg, names, root / "docs") if cfg.measure else []
    for path, text in pages(cfg, root).items():
        with atomic_path(path) as temporary:
            temporary.write_text(text)
        print(path)
    if failures:
        raise UserError("not measured, what was kept of them before stays: " + "; ".join(failures))


main = command("benchmark_page")(_benchmark_page)

if __name__ == "__main__":
    main()
