"""Output of a run to TensorBoard, with the same tags in every run."""

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pandas as pd
from hydra.core.hydra_config import HydraConfig
from matplotlib.image import imread
from omegaconf import DictConfig, OmegaConf
from torch.utils.tensorboard import SummaryWriter
from torch.utils.tensorboard.summary import hparams

from narx.inference.checkpoint import Checkpoint

# groups of the configuration whose choice is a column in the table of runs
_COMPARED = ("data", "split", "calibration", "teacher", "model", "optimizer")
# where things are, which does not change a result
_WITHOUT_COLUMN = frozenset({"data_root", "prepared.folder", "debug"})


class TensorBoardLog:
    """Event file of one run, closed at the end of a `with` block.

    Parameters
    ----------
    directory : pathlib.Path
        Folder of the event file. An event file of an interrupted run in it is deleted, because
        TensorBoard would join the two curves.
    """

    def __init__(self, directory: Path) -> None:
        for left_over in directory.glob("events.out.tfevents.*"):
            left_over.unlink()
        self._directory = directory
        self._writer = SummaryWriter(str(directory))

    def __enter__(self) -> "TensorBoardLog":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._writer.close()

    def of_fold(self, name: str) -> "TensorBoardLog":
        """Open the log of one fold as a separate run, so that its tags need not contain the fold.

        Parameters
        ----------
        name : str
            Name of the subfolder of this run's log.

        Returns
        -------
        TensorBoardLog
            Log, to be closed by the caller.
        """
        return TensorBoardLog(self._directory / name)

    def iteration(self, number: int, numbers: Mapping[str, float]) -> None:
        """Show the numbers of one iteration of a training.

        Parameters
        ----------
        number : int
            Number of the iteration.
        numbers : mapping of str to float
            By name; each has the tag ``training/<name>``.
        """
        for name, value in numbers.items():
            self._writer.add_scalar(f"training/{name}", value, number)

    def best_start(self, network: Checkpoint) -> None:
        """Show the training of the best start, and the largest pole that it ended with.

        Parameters
        ----------
        network : Checkpoint
            Trained network; its history has the numbers of each iteration: cost, gradient, and
            damping if the optimiser has one. Whether the iteration lowered the cost is shown as
            ``accepted``, 1 or 0.
        """
        history = network.history["report"]["history"]
        for number, now in enumerate(history):
            shown = {f"best_start/{name}": value for name, value in now.items()}
            after = history[number + 1] if number + 1 < len(history) else None
            if after is not None and after["stage"] == now["stage"]:
                lower = after["cost_deg2"] < now["cost_deg2"]
                shown["best_start/accepted"] = float(lower)
            self.iteration(number, {n: value for n, value in shown.items() if np.isfinite(value)})
        self.scalars({"largest_pole": network.history["stability"]["largest_pole"]})

    def configuration(self, cfg: DictConfig, fold: str) -> None:
        """Show the configuration and the fold as text.

        Parameters
        ----------
        cfg : omegaconf.DictConfig
            Configuration of the run.
        fold : str
            Name of the training fold.
        """
        yaml = OmegaConf.to_yaml(cfg, resolve=True)
        self._writer.add_text("configuration", "    " + yaml.replace("\n", "\n    "))
        self._writer.add_text("fold", fold)

    def weights(self, network: Checkpoint) -> None:
        """Show histograms of the trained weights.

        Parameters
        ----------
        network : Checkpoint
            Trained network.
        """
        for name, values in network.model.named_parameters():
            self._writer.add_histogram(f"weights/{name}", values.detach().numpy())

    def results(self, results: pd.DataFrame) -> dict[str, float]:
        """Show the mean RMSE of every segment, axis and method.

        Parameters
        ----------
        results : pandas.DataFrame
            Columns of ``results.csv``.

        Returns
        -------
        dict of str to float
            The logged values, by tag.
        """
        means = results.groupby(["segment", "axis", "method"])["rmse_deg"].mean().dropna()
        names = means.index.to_frame(index=False).to_numpy()
        shown = {
            "/".join(["rmse_deg", *map(str, parts)]): float(value)
            for parts, value in zip(names, means, strict=True)
        }
        self.scalars(shown)
        return shown

    def scalars(self, numbers: Mapping[str, float]) -> None:
        """Log numbers that a run has only once.

        Parameters
        ----------
        numbers : mapping of str to float
            By tag.
        """
        for tag, value in numbers.items():
            self._writer.add_scalar(tag, value)

    def table_of_runs(self, cfg: DictConfig, metrics: Mapping[str, float]) -> None:
        """Add the run to the table of the HPARAMS page.

        Parameters
        ----------
        cfg : omegaconf.DictConfig
            The columns are its seed, the choices of its groups and what was set besides: all
            settings would be a hundred columns, of which hardly any differs.
        metrics : mapping of str to float
            Metrics shown next to the settings, under the tags of scalars that were logged before.
        """
        # `add_hparams` of torch would open a second run for it
        writer: Any = self._writer.file_writer
        for summary in hparams(_settings(cfg), dict(metrics)):
            writer.add_summary(summary)

    def figure(self, name: str, path: Path) -> None:
        """Show a figure that has been written, which is faster than to draw it again.

        Parameters
        ----------
        name : str
            Its tag.
        path : pathlib.Path
            PNG file.
        """
        self._writer.add_image(name, imread(path), dataformats="HWC")


def _settings(cfg: DictConfig) -> dict[str, bool | float | str]:
    hydra = HydraConfig.get()
    keys = [override.partition("=")[0].lstrip("+~") for override in hydra.overrides.task]
    choices = {key: hydra.runtime.choices[key] for key in _COMPARED if key in hydra.runtime.choices}
    set_here = {key: OmegaConf.select(cfg, key) for key in keys if key not in _WITHOUT_COLUMN}
    values = {"seed": cfg.seed} | set_here | choices
    return {key: _plain(value) for key, value in values.items() if value is not None}


def _plain(value: Any) -> bool | float | str:
    if isinstance(value, np.generic):
        value = value.item()
    return value if isinstance(value, bool | int | float | str) else str(value)
