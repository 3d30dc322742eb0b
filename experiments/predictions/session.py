"""Predict several sensors of one session: angles, strides and a figure from their files."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from omegaconf import DictConfig, ListConfig

from narx.datasets.apdm_file import SUFFIXES as APDM_SUFFIXES
from narx.datasets.csv_recording import read_recording
from narx.errors import UserError
from narx.experiments.predictions.angle_files import check_suffix, write_angles
from narx.experiments.predictions.options import interval_s, layout_of
from narx.experiments.predictions.session_tables import angle_table, cycle_table, stride_table
from narx.inference.pretrained import load_or_pretrained
from narx.inference.session import SessionPrediction, SessionStart, predict_session
from narx.recordings.session_clock import BY_STAMPS
from narx.recordings.trial import Trial

_STRIDES, _CYCLE, _FIGURE = "strides.csv", "cycle.csv", "cycle.png"


def predict_files(cfg: DictConfig, files: Mapping[str, Path], target: Path) -> tuple[str, ...]:
    """Predict a session and write all its output.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``.
    files : mapping of str to pathlib.Path
        File of each segment.
    target : pathlib.Path
        File for the angles; strides, gait cycle and figure are written beside it, as in
        `files_of_strides`.

    Returns
    -------
    tuple of str
        What was done to the recordings, as printed.

    Raises
    ------
    UserError
        If an option or a recording is invalid.
    """
    check_suffix(target)
    layout = layout_of(cfg)
    session = predict_session(
        {segment: read_recording(path, segment, layout) for segment, path in files.items()},
        load_or_pretrained(cfg.checkpoint).method(cfg.smoothing),
        calibration=cfg.calibration,
        start_pose=cfg.start_pose,
        still_s=_stands(cfg),
        walking_s=interval_s(cfg.walking_s, "walking_s"),
        align=_alignment(cfg),
        where=", ".join(str(path) for path in files.values()),
    )
    print(*session.notes, sep="\n")
    n_angles = _write(session, target)
    joints = [name for name in session.angles_rad if name not in files]
    print(f"{target}: {', '.join([*files, *joints])}, {n_angles} samples with angles")
    summary = _summary(session)
    if summary:
        print(f"{_beside(target, _FIGURE)}: {summary}")
    else:
        print("no strides found; no stride tables or figure")
    return session.notes


def _alignment(cfg: DictConfig) -> Any:
    """Return the name of a way to align, or the time of an event per sensor, as checked before."""
    return dict(cfg.align) if isinstance(cfg.align, DictConfig) else cfg.align


def predict_trial(cfg: DictConfig, trial: Trial, target: Path) -> tuple[SessionPrediction, int]:
    """Predict a trial of a source and write everything about it.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``; its options take precedence over the trial's.
    trial : Trial
        As read.
    target : pathlib.Path
        As for `predict_files`.

    Returns
    -------
    session : SessionPrediction
        What was written; its notes begin with the trial's.
    n_angles : int
        Samples with angles.

    Raises
    ------
    UserError
        If an option or a recording is wrong.
    """
    start: SessionStart = cfg.start_pose
    if start == "auto" and not trial.starts_in_calibration_posture:
        start = "unknown"
    session = predict_session(
        trial.imus,
        load_or_pretrained(cfg.checkpoint).method(cfg.smoothing),
        calibration=cfg.calibration,
        parts=trial.calibration,
        start_pose=start,
        still_s=_stands(cfg) or trial.still_s or None,
        walking_s=interval_s(cfg.walking_s, "walking_s") or trial.walking_s,
        align="stamps",
        where=trial.name,
    )
    # the trial's own notes tell how its sensors came to be on one clock
    own = (note for note in session.notes if note != BY_STAMPS)
    session = replace(session, notes=(*trial.notes, *own))
    return session, _write(session, target)


def _write(session: SessionPrediction, target: Path) -> int:
    """Write angles, strides, gait cycle and figure; return the number of samples with angles."""
    write_angles(angle_table(session), target)
    cycles = cycle_table(session)
    if len(cycles):
        write_angles(stride_table(session), _beside(target, _STRIDES))
        write_angles(cycles, _beside(target, _CYCLE))
        # imported here, since other predictions need no matplotlib, nor the time to import it
        from narx.experiments.figures.canvas import save_figure
        from narx.experiments.figures.cycles import cycle_figure

        save_figure(cycle_figure(cycles, target.stem), _beside(target, _FIGURE))
    last = list(session.angles_rad)[-1]
    return int(np.isfinite(session.angles_rad[last]).all(axis=1).sum())


def files_of_strides(target: Path) -> list[Path]:
    """List the files that are written with the angles of a session.

    Parameters
    ----------
    target : pathlib.Path
        File for the angles.

    Returns
    -------
    list of pathlib.Path
        Strides, gait cycle and its figure: ``knee_strides.csv`` of ``knee.csv``; of another format
        with the whole name, as ``knee.sto_strides.csv``, since that may be another session.
    """
    return [_beside(target, name) for name in (_STRIDES, _CYCLE, _FIGURE)]


def _beside(target: Path, name: str) -> Path:
    of = target.stem if target.suffix.lower() == ".csv" else target.name
    return target.with_name(f"{of}_{name}")


def _stands(cfg: DictConfig) -> list[tuple[float, float]] | None:
    still = cfg.still_s
    if isinstance(still, ListConfig) and still and isinstance(still[0], ListConfig):
        intervals = [interval_s(one, "still_s") for one in still]
    else:
        intervals = [interval_s(still, "still_s")]
    return [one for one in intervals if one is not None] or None


def _summary(session: SessionPrediction) -> str:
    parts = []
    for side, contacts in session.contacts_s.items():
        if len(contacts) > 1:
            cadence = 120.0 / float(np.median(np.diff(contacts)))
            parts.append(f"{side} {len(contacts) - 1} strides, {cadence:.0f} steps a minute")
    return "; ".join(parts)


def session_files(value: DictConfig) -> dict[str, Path]:
    """Read the files of a session from the configuration.

    Parameters
    ----------
    value : omegaconf.DictConfig
        File of each segment.

    Returns
    -------
    dict of str to pathlib.Path
        The same, as paths.

    Raises
    ------
    UserError
        If the same file is given for two segments.
    """
    files: dict[str, Path] = {}
    for segment, path in value.items():
        several = Path(str(path)).suffix.lower() in APDM_SUFFIXES
        if Path(str(path)) in files.values() and not several:
            raise UserError(f"input: '{path!s}' is given for two segments")
        files[str(segment)] = Path(str(path))
    return files
