"""Predict one sensor: the angles of its segment from its file."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd
from omegaconf import DictConfig

from narx.calibration.static_bias import resting_mean
from narx.datasets.csv_recording import read_recording
from narx.datasets.segment_names import segment_in_name
from narx.errors import UserError
from narx.experiments.predictions.angle_files import write_angles
from narx.experiments.predictions.options import interval_s, layout_of
from narx.inference.checkpoint import Checkpoint
from narx.inference.predict import Prediction, Side, predict
from narx.inference.pretrained import load_or_pretrained
from narx.kinematics.segment_angles import AXES
from narx.recordings.rest import first_rest_s
from narx.recordings.trial import ImuRecording
from narx.types import FloatArray

# shortest rest at the start that is noted, s
_NOTED_REST_S = 0.5


def table_of(prediction: Prediction) -> pd.DataFrame:
    """Tabulate angles in degrees, as written to a file.

    Parameters
    ----------
    prediction : Prediction
        Angles of one segment.

    Returns
    -------
    pandas.DataFrame
        ``time_s``, ``sagittal_deg``, ``frontal_deg``, ``transverse_deg``, and
        ``sagittal_std_deg`` etc. if the network predicts its standard deviation, and ``quality``
        (`narx.inference.stream.Quality`).
    """
    columns = {"time_s": prediction.time_s}
    for k, axis in enumerate(AXES):
        columns[f"{axis}_deg"] = np.degrees(prediction.angles_rad[:, k]).round(6)
    if prediction.std_rad is not None:
        for k, axis in enumerate(AXES):
            columns[f"{axis}_std_deg"] = np.degrees(prediction.std_rad[:, k]).round(6)
    return pd.DataFrame(columns).assign(quality=prediction.quality)


@lru_cache(maxsize=1)
def _network(path: str | None) -> Checkpoint:
    return load_or_pretrained(path)


def predict_file(cfg: DictConfig, source: Path, target: Path, side: Side) -> tuple[Prediction, int]:
    """Predict one file and write its angles.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``.
    source, target : pathlib.Path
        Recording, and output file for its angles.
    side : {"right", "left"}
        Leg.

    Returns
    -------
    prediction : Prediction
        The prediction that was written.
    n_angles : int
        Number of samples with angles.

    Raises
    ------
    UserError
        If an option or the recording is invalid.
    """
    still_s = interval_s(cfg.still_s, "still_s")
    recording = read_recording(source, layout=layout_of(cfg))
    prediction = predict(
        recording,
        _network(cfg.checkpoint).method(cfg.smoothing),
        frame=cfg.frame,
        side=side,
        # the zero of a single segment is rarely known; a session is checked for rest at its start
        start_pose="unknown" if cfg.start_pose == "auto" else cfg.start_pose,
        remove_bias=cfg.remove_bias,
        still_s=still_s,
        bias_rad_s=_bias_rad_s(cfg),
        where=str(source),
    )
    if cfg.start_pose == "auto":
        prediction = replace(prediction, notes=(*prediction.notes, *_standing_note(recording)))
    write_angles(table_of(prediction), target, segment_in_name(source.stem))
    return prediction, int(np.isfinite(prediction.angles_rad).all(axis=1).sum())


def _standing_note(recording: ImuRecording) -> list[str]:
    """Report a rest at the start that is not used as the zero of the angles."""
    rest_s = first_rest_s([recording.gyroscope_rad_s], recording.sampling_rate_hz)
    if rest_s < _NOTED_REST_S:
        return []
    return [
        f"begins with {rest_s:.1f} s of rest, which is not used as the zero of the angles; if it "
        "is upright standing, give start_pose=known"
    ]


def _bias_rad_s(cfg: DictConfig) -> FloatArray | None:
    """Read the bias from the option that gives it, if any."""
    if cfg.still_file is None:
        return None if cfg.bias_rad_s is None else np.array(list(cfg.bias_rad_s), dtype=float)
    others = {
        "bias_rad_s": cfg.bias_rad_s is not None,
        "still_s": cfg.still_s is not None,
        "remove_bias=false": not cfg.remove_bias,
    }
    for other, given in others.items():
        if given:
            raise UserError(f"{other} and still_file exclude each other; give one of them")
    recording = read_recording(Path(str(cfg.still_file)), layout=layout_of(cfg))
    still = resting_mean(recording.gyroscope_rad_s, recording.sampling_rate_hz, str(cfg.still_file))
    if still is None:
        raise UserError(f"{cfg.still_file}: no sample at rest from which to measure the bias")
    return still.bias_rad_s
