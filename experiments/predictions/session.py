"""Several sensors of one session: from their files to angles, strides and a figure."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from omegaconf import DictConfig, ListConfig

from narx.datasets.csv_recording import read_recording
from narx.errors import UserError
from narx.experiments.figures.canvas import save_figure
from narx.experiments.figures.cycles import cycle_figure
from narx.experiments.predictions.angle_files import check_suffix, write_angles
from narx.experiments.predictions.options import interval_s, layout_of
from narx.experiments.predictions.session_tables import angle_table, cycle_table, stride_table
from narx.inference.pretrained import load_or_pretrained
from narx.inference.session import SessionPrediction, predict_session


def predict_files(cfg: DictConfig, files: Mapping[str, Path], target: Path) -> None:
    """Predict a session and write everything about it.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``.
    files : mapping of str to pathlib.Path
        File of each segment.
    target : pathlib.Path
        File for the angles; strides, gait cycle and figure are written beside it, as
        ``<name>_strides.csv``, ``<name>_cycle.csv`` and ``<name>_cycle.png``.

    Raises
    ------
    UserError
        If an option or a recording is wrong.
    """
    check_suffix(target)
    session = _predicted(cfg, files)
    write_angles(angle_table(session), target)
    beside = {part: target.with_name(f"{target.stem}_{part}") for part in ("strides", "cycle")}
    strides, cycles = stride_table(session), cycle_table(session)
    print(*session.notes, sep="\n")
    joints = [name for name in session.angles_rad if name not in files]
    n_angles = int(np.isfinite(session.angles_rad[[*files, *joints][-1]]).all(axis=1).sum())
    print(f"{target}: {', '.join([*files, *joints])}, {n_angles} samples with angles")
    if len(cycles):
        write_angles(strides, beside["strides"].with_suffix(".csv"))
        write_angles(cycles, beside["cycle"].with_suffix(".csv"))
        figure = beside["cycle"].with_suffix(".png")
        save_figure(cycle_figure(cycles, target.stem), figure)
        print(f"{figure}: {_summary(session)}")
    else:
        print("no strides found, so none are cut")


def _predicted(cfg: DictConfig, files: Mapping[str, Path]) -> SessionPrediction:
    layout = layout_of(cfg)
    still = cfg.still_s
    if isinstance(still, ListConfig) and still and isinstance(still[0], ListConfig):
        intervals = [interval_s(one, "still_s") for one in still]
    else:
        intervals = [interval_s(still, "still_s")]
    known = [one for one in intervals if one is not None]
    return predict_session(
        {segment: read_recording(path, segment, layout) for segment, path in files.items()},
        load_or_pretrained(cfg.checkpoint).method(cfg.smoothing),
        calibration=cfg.calibration,
        start_pose=cfg.start_pose,
        still_s=known or None,
        walking_s=interval_s(cfg.walking_s, "walking_s"),
        align=cfg.align,
        where=", ".join(str(path) for path in files.values()),
    )


def _summary(session: SessionPrediction) -> str:
    parts = []
    for side, contacts in session.contacts_s.items():
        if len(contacts) > 1:
            cadence = 120.0 / float(np.median(np.diff(contacts)))
            parts.append(f"{side} {len(contacts) - 1} strides, {cadence:.0f} steps a minute")
    return "; ".join(parts)


def session_files(value: DictConfig) -> dict[str, Path]:
    """Take the files of a session from the configuration.

    Parameters
    ----------
    value : omegaconf.DictConfig
        Segment to file.

    Returns
    -------
    dict of str to pathlib.Path
        The same.

    Raises
    ------
    UserError
        If a file is given twice.
    """
    files: dict[str, Path] = {}
    for segment, path in value.items():
        if Path(str(path)) in files.values():
            raise UserError(f"input: '{path!s}' is given for two segments")
        files[str(segment)] = Path(str(path))
    return files
