"""Train the network of a fold, as the configuration says."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from narx.calibration.calibrate import calibrate
from narx.datasets.base import TrialSource
from narx.datasets.splits import Fold, TrialPart, load
from narx.errors import UserError
from narx.inference import checkpoint as checkpoints
from narx.inference.checkpoint import Checkpoint
from narx.inference.pretrained import pretrained
from narx.inference.start_up import StartUp
from narx.inference.washout import washout_gain
from narx.recordings.trial import Trial
from narx.training.design import NetworkDesign, train_network
from narx.training.objective import Log, Objective
from narx.training.teachers import Teacher
from narx.types import BoolArray, FloatArray
from narx.windows.sequences import TrainingSequence, contiguous, hold_back

_Std = tuple[float, float, float]


def network_of(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    fold: Fold,
    rng: np.random.Generator,
    log: Log,
) -> Checkpoint:
    """Train, load, or take the shipped network for a fold.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        The command's configuration.
    sources : mapping of str to TrialSource
        By name.
    fold : Fold
        What may be trained on.
    rng : numpy.random.Generator
        Starts of the training.
    log : callable
        Told how training goes.

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
        cfg = choose(cfg, sources, fold)
    return train(cfg, sources, fold, rng, log)


def choose(cfg: DictConfig, sources: Mapping[str, TrialSource], fold: Fold) -> DictConfig:
    """Choose among candidate settings without a look at the test part (nested validation).

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        Holds `candidates`: overrides such as ``model.hidden=3``, several of one candidate
        separated by spaces.
    sources : mapping of str to TrialSource
        By name.
    fold : Fold
        Its training trials are left out one by one; the candidate with the smallest mean
        closed-loop error on them wins.

    Returns
    -------
    omegaconf.DictConfig
        The configuration with the chosen candidate.

    Raises
    ------
    UserError
        If there are fewer than two training trials to choose by.
    """
    keys = list(dict.fromkeys(part.key for part in fold.training))
    if len(keys) < 2:
        raise UserError(f"candidates: fold {fold.name} has one training trial, two are needed")
    best: tuple[float, DictConfig] | None = None
    for overrides in cfg.candidates:
        candidate = cfg.copy()
        candidate.merge_with_dotlist(str(overrides).split())
        errors = []
        for key in keys:
            inner = Fold(
                f"{fold.name} without {'/'.join(key)}",
                tuple(part for part in fold.training if part.key != key),
                (),
                tuple(part for part in fold.training if part.key == key),
            )
            # every candidate meets the same starts
            rng = np.random.default_rng(cfg.seed)
            network = train(candidate, sources, inner, rng, lambda iteration, numbers: None)
            errors.append(network.history["report"]["restarts"]["validation_rmse_best_deg"])
        if best is None or float(np.mean(errors)) < best[0]:
            best = float(np.mean(errors)), candidate
    assert best is not None
    return best[1]


def train(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    fold: Fold,
    rng: np.random.Generator,
    log: Log,
) -> Checkpoint:
    """Train a network on the training part of a fold.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        Holds `model`, `optimizer`, `teacher`, `training`.
    sources : mapping of str to TrialSource
        By name.
    fold : Fold
        What may be trained on.
    rng : numpy.random.Generator
        Starts of the training.
    log : callable
        Told how training goes.

    Returns
    -------
    Checkpoint
        Trained network with its report, stability statement and error.

    Raises
    ------
    UserError
        If there is nothing to train on.
    """
    washout_gain(cfg.model.washout_s, 1.0)  # refused before the training, not after it
    teacher: Teacher = instantiate(cfg.teacher)
    hashes: dict[str, str] = {}
    training = list(_sequences(cfg, sources, fold.training, teacher, hashes))
    if not training:
        names = ", ".join("/".join(part.key) for part in fold.training)
        raise UserError(f"training: no stretch without gaps in {names}")
    if fold.validation:
        validation = list(_sequences(cfg, sources, fold.validation, teacher, hashes))
    else:
        training, validation = hold_back(training, cfg.training.held_back)
    settings: dict[str, Any] = {str(key): value for key, value in cfg.model.items()}
    objective = dict(settings.pop("objective"))
    objective["axis_weights"] = tuple(objective["axis_weights"])
    start_up = StartUp(**settings.pop("start_up"))
    axis_scaling, washout_s = settings.pop("axis_scaling"), settings.pop("washout_s")
    model, history = train_network(
        training,
        validation,
        NetworkDesign(**settings),
        Objective(**objective),
        instantiate(cfg.optimizer),
        rng,
        log,
    )
    config = OmegaConf.to_container(cfg, resolve=True)
    assert isinstance(config, dict)
    # where recordings lie is nobody's business who gets the network
    config.pop("data_root")
    history |= {
        "fold": fold.name,
        "config": config,
        "data_sha256": hashes,
    }
    network = Checkpoint(model, start_up, axis_scaling, history=history, washout_s=washout_s)
    after, start = _error_stds(network, sources, fold, cfg)
    return replace(network, error_std_rad=after, start_std_rad=start)


def _sequences(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    parts: Iterable[TrialPart],
    teacher: Teacher,
    hashes: dict[str, str],
) -> Iterable[TrainingSequence]:
    for part in parts:
        trial = load(sources, part)
        hashes |= trial.sources
        keep = _inside(trial, part, cfg.training.skip_s)
        for name, segment in calibrate(trial, cfg.calibration).items():
            if cfg.training.segments is not None and name not in cfg.training.segments:
                continue
            weight = float(cfg.training.weights.get(trial.dataset, 1.0))
            target = teacher.angles_rad(trial.dataset, segment)
            yield from contiguous(f"{trial.name}/{name}", segment.signals, target, keep, weight)


def _inside(trial: Trial, part: TrialPart, skip_s: float) -> BoolArray:
    since_start_s = trial.time_s - trial.time_s[0]
    inside = (since_start_s >= max(skip_s, part.start_s)) & (since_start_s < part.stop_s)
    return np.asarray(inside)


def _error_stds(
    network: Checkpoint, sources: Mapping[str, TrialSource], fold: Fold, cfg: DictConfig
) -> tuple[_Std, _Std] | tuple[None, None]:
    # root mean square error of the whole method on the trials trained on, where there is a
    # reference, after the start-up and during it: what the standard deviation of an estimate is
    # taken to be
    method = network.method()
    total, count = np.zeros((2, 3)), np.zeros((2, 3))
    for part in {part.key: part for part in fold.training}.values():
        trial = load(sources, part)
        keep = trial.time_s - trial.time_s[0] >= cfg.training.skip_s
        for segment in calibrate(trial, cfg.calibration).values():
            if segment.reference_angles_rad is None:
                continue
            error = segment.reference_angles_rad - method.estimate(segment.signals)
            starting = method.starting(segment.signals)
            for row, when in enumerate((keep & starting, keep & ~starting)):
                total[row] += np.nansum(error[when] ** 2, axis=0)
                count[row] += np.isfinite(error[when]).sum(axis=0)
    if not count.any():
        return None, None
    start, after = np.sqrt(np.divide(total, count, out=np.full((2, 3), np.nan), where=count > 0))
    after = np.where(np.isfinite(after), after, start)
    return _as_std(after), _as_std(start)


def _as_std(values_rad: FloatArray) -> _Std:
    sagittal, frontal, transverse = map(float, values_rad)
    return sagittal, frontal, transverse
