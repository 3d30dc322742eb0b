"""Change one choice of the network at a time and tabulate the effect.

python -m experiments.ablation data_root=DIR
"""

import pandas as pd
from omegaconf import DictConfig
from tqdm import tqdm

from narx.errors import UserError
from narx.evaluation.results import write_results
from narx.experiments import benchmark
from narx.experiments.command import command, run_directory
from narx.experiments.configuration import composed_configuration
from narx.experiments.runs.record import environment, seed_everything, write_json
from narx.experiments.tables.table import Table, as_markdown
from narx.files import atomic_path
from narx.recordings.trial import kind_of


def ablation_table(results: pd.DataFrame, quantity: str) -> Table:
    """Tabulate the variants.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``, with the variant's name as the method.
    quantity : {"precision_deg", "rmse_deg"}
        What is averaged: over trials and sides within each subject, then over subjects.

    Returns
    -------
    Table
        One row per variant, one column per segment and axis; the mean and the worst trial.
    """
    sided = results.assign(segment=results["segment"].map(kind_of))
    where = sided["segment"] + " " + sided["axis"]
    sided = sided.assign(column=where)[sided[quantity].notna()]
    by_subject = sided.groupby(["method", "column", "subject"], sort=False)[quantity].mean()
    mean = by_subject.groupby(["method", "column"], sort=False).mean().unstack("column")
    worst = sided.groupby(["method", "column"], sort=False)[quantity].max().unstack("column")
    frame = pd.concat({"": mean, "worst trial": worst}, axis=1).swaplevel(axis=1)
    frame = frame.reindex(list(dict.fromkeys(sided["method"])))
    frame.columns = [" ".join(part for part in column if part) for column in frame.columns]
    frame = frame[sorted(frame.columns)]
    frame.index.name = "Variant"
    return Table(
        f"{quantity.removesuffix('_deg')} (°), mean over subjects",
        frame,
        dict.fromkeys(frame.columns, 2),
    )


def _ablation(cfg: DictConfig) -> None:
    seed_everything(cfg.seed)
    directory = run_directory()
    frames: list[pd.DataFrame] = []
    sources: dict[str, str] = {}
    # all are checked before the first runs
    common = [] if cfg.data_root is None else [f"data_root={cfg.data_root}"]
    common += [f"seed={cfg.seed}", "methods=[narx]", *cfg.overrides]
    variants = {
        str(name): composed_configuration("benchmark", [*common, *more], f"variants.{name}")
        for name, more in cfg.variants.items()
    }
    for name, variant in tqdm(variants.items(), desc="variants", disable=None):
        try:
            gathered = benchmark.run(variant)
        except UserError as error:
            print(f"{name}: left out: {error}")
            continue
        frames.append(gathered.results.assign(method=name))
        sources |= gathered.sources
    if not frames:
        raise UserError("ablation: no variant could be run")
    results = pd.concat(frames, ignore_index=True)
    write_results(results, directory / "results.csv")
    write_json(environment(cfg.seed, sources), directory / "environment.json")
    text = as_markdown([ablation_table(results, q) for q in ("precision_deg", "rmse_deg")])
    with atomic_path(directory / "ablation.md") as temporary:
        temporary.write_text(text + "\n")
    print(text)
    print(f"\nresults.csv and ablation.md: {directory}")


main = command("ablation")(_ablation)

if __name__ == "__main__":
    main()
