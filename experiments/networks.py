"""Train the network of a fold as configured."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from yaml import YAMLError

from narx.datasets.base import TrialSource
from narx.datasets.splits import Fold
from narx.errors import UserError
from narx.experiments.model import ModelSettings
from narx.inference import checkpoint as checkpoints
from narx.inference.checkpoint import Checkpoint
from narx.inference.pretrained import pretrained
from narx.training.objective import Log
from narx.training.trainer import Trainer
from narx.training.trial_reader import TrialReader


def network_of(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    fold: Fold,
    log: Log,
    progress_folder: Path | None = None,
) -> Checkpoint:
    """Train the network of a fold, or load one, or use the shipped one.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        The command's configuration.
    sources : mapping of str to TrialSource
        By name.
    fold : Fold
        What may be trained on.
    log : callable
        Called with iteration and numbers by name.
    progress_folder : pathlib.Path, optional
        As `narx.Trainer`.

    Returns
    -------
    Checkpoint
        Trained network.
    """
    if cfg.get("checkpoint") is not None:
        return checkpoints.load(Path(cfg.checkpoint))
    if not fold.training:
        return pretrained()
    if cfg.get("candidates"):
        cfg = choose(cfg, sources, fold, progress_folder)
    return train(cfg, sources, fold, log, progress_folder)


def choose(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    fold: Fold,
    progress_folder: Path | None = None,
) -> DictConfig:
    """Choose among candidate settings by nested validation, without using the test part.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With `candidates`: overrides such as ``model.hidden=3``; several overrides of one candidate
        are separated by spaces.
    sources : mapping of str to TrialSource
        By name.
    fold : Fold
        Each of its training trials is left out once; the candidate with the smallest mean
        closed-loop error on these trials is chosen.
    progress_folder : pathlib.Path, optional
        As `narx.Trainer`.

    Returns
    -------
    omegaconf.DictConfig
        The configuration with the chosen candidate.

    Raises
    ------
    UserError
        If there are fewer than two training trials.
    """
    keys = list(dict.fromkeys(part.key for part in fold.training))
    if len(keys) < 2:
        raise UserError(f"candidates: fold {fold.name} has one training trial, two are needed")
    best: tuple[float, DictConfig] | None = None
    for overrides in cfg.candidates:
        candidate = candidate_of(cfg, overrides)
        errors = []
        for key in keys:
            inner = Fold(
                f"{fold.name} without {'/'.join(key)}",
                tuple(part for part in fold.training if part.key != key),
                (),
                tuple(part for part in fold.training if part.key == key),
            )
            network = train(
                candidate, sources, inner, lambda iteration, numbers: None, progress_folder
            )
            errors.append(network.history["report"]["restarts"]["validation_rmse_best_deg"])
        if best is None or float(np.mean(errors)) < best[0]:
            best = float(np.mean(errors)), candidate
    assert best is not None
    return best[1]


def candidate_of(cfg: DictConfig, overrides: str) -> DictConfig:
    """Apply the overrides of a candidate.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        The command's configuration.
    overrides : str
        Such as ``model.hidden=6 optimizer.prior_deg2=10``.

    Returns
    -------
    omegaconf.DictConfig
        A copy with them.

    Raises
    ------
    UserError
        If one of them is not ``key=value``.
    """
    candidate = cfg.copy()
    try:
        candidate.merge_with_dotlist(overrides.split())
    except (ValueError, TypeError, AttributeError, YAMLError) as error:
        raise UserError(f"expected key=value ({error})") from error
    if set(candidate) != set(cfg):
        raise UserError("expected keys of the configuration, with a value: key=value")
    return candidate


def train(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    fold: Fold,
    log: Log,
    progress_folder: Path | None = None,
) -> Checkpoint:
    """Train a network on the training part of a fold.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With `model`, `optimizer`, `teacher`, `training`.
    sources : mapping of str to TrialSource
        By name.
    fold : Fold
        What may be trained on.
    log : callable
        Called with iteration and numbers by name.
    progress_folder : pathlib.Path, optional
        As `narx.Trainer`.

    Returns
    -------
    Checkpoint
        Trained network with its report, stability statement and error.

    Raises
    ------
    UserError
        If there is nothing to train on.
    """
    made = replace(trainer(cfg), progress_folder=progress_folder)
    network = made.fit_fold(sources, fold, log)
    config = OmegaConf.to_container(cfg, resolve=True)
    assert isinstance(config, dict)
    # the location of the recordings is of no use to the recipient of the network
    config.pop("data_root")
    return replace(network, history=network.history | {"config": config})


def trainer(cfg: DictConfig) -> Trainer:
    """Create the trainer described by a configuration.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With `model`, `optimizer`, `teacher`, `calibration`, `training`.

    Returns
    -------
    Trainer
        Ready to fit.
    """
    model: ModelSettings = instantiate(cfg.model, _convert_="all")
    segments, start = cfg.training.segments, cfg.training.start
    return Trainer(
        model,
        model.objective,
        instantiate(cfg.optimizer, _convert_="all"),
        TrialReader(
            instantiate(cfg.teacher, _convert_="all"),
            cfg.calibration,
            cfg.training.skip_s,
            None if segments is None else tuple(segments),
            dict(cfg.training.weights),
        ),
        model.start_up,
        model.axis_scaling,
        model.washout_s,
        cfg.training.held_back,
        cfg.training.align_clock,
        cfg.training.seed,
        model.tracker,
        None if start is None else checkpoints.load(Path(start)),
    )
