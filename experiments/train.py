"""Train a network and leave it as a checkpoint.

python -m experiments.train data=smartphone_pocket data_root=DIR teacher=reference seed=1
"""

import numpy as np
from hydra.utils import instantiate
from omegaconf import DictConfig
from tqdm import tqdm

from narx.errors import UserError
from narx.experiments.command import command, run_directory
from narx.experiments.figures.canvas import save_figure
from narx.experiments.networks import choose, train
from narx.experiments.reports.networks import training_history_figure
from narx.experiments.runs.record import environment, seed_everything, write_json
from narx.experiments.sources import combined_index, open_sources
from narx.experiments.tensorboard_log import TensorBoardLog
from narx.inference import checkpoint as checkpoints


def _train(cfg: DictConfig) -> float:
    """Train on the first fold of the split; returns the validation error, for sweeps."""
    seed_everything(cfg.seed)
    rng = np.random.default_rng(cfg.seed)
    directory = run_directory()
    sources = open_sources(cfg)
    folds = list(instantiate(cfg.split)(combined_index(sources), rng))
    if len(folds) != 1:
        raise UserError(
            f"split: training makes one network, this split has {len(folds)} folds; use "
            "split=everything or split=one_window, or narx.experiments.benchmark to test every fold"
        )
    with (
        TensorBoardLog(directory / "tensorboard") as log,
        tqdm(desc="iterations", unit="it", disable=None) as progress,
    ):
        to_tensorboard = log.for_fold(folds[0].name)

        def told(iteration: int, numbers: dict[str, float]) -> None:
            to_tensorboard(iteration, numbers)
            progress.update()

        if cfg.candidates:
            cfg = choose(cfg, sources, folds[0])
        network = train(cfg, sources, folds[0], rng, told)
        report = network.history["report"]
        figure = training_history_figure(network, folds[0].name)
        save_figure(figure, directory / "figures" / "training.png")
        log.figure("training", figure)
    checkpoints.save(network, directory / "checkpoint.pt")
    write_json(
        environment(cfg.seed, network.history["data_sha256"]), directory / "environment.json"
    )
    write_json(
        {key: value for key, value in network.history.items() if key != "config"},
        directory / "training.json",
    )
    best = report["restarts"]["validation_rmse_best_deg"]
    print(
        f"{folds[0].name}: {network.history['training_s']:.0f} s of training, stopped by "
        f"{report['code']}, held-back error {best:.3f} deg\n{directory / 'checkpoint.pt'}"
    )
    return float(best)


main = command("train")(_train)

if __name__ == "__main__":
    main()
