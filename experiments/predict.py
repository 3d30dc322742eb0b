"""Angles from recordings, with a trained network: of one segment, or of a leg and its joints.

python -m experiments.predict checkpoint=PATH input=walk.csv output=angles.csv
python -m experiments.predict "input={thigh_right: a.csv, shank_right: b.csv}" output=knee.csv
"""

from pathlib import Path

import numpy as np
import pandas as pd
from omegaconf import DictConfig

from narx.datasets.csv_recording import read_recording
from narx.errors import UserError
from narx.experiments.command import command
from narx.experiments.predictions.angle_files import check_suffix, write_angles
from narx.experiments.predictions.options import interval_s, layout_of
from narx.experiments.predictions.session import predict_files, session_files
from narx.inference.predict import Prediction, predict
from narx.inference.pretrained import load_or_pretrained
from narx.kinematics.segment_angles import AXES


def table_of(prediction: Prediction) -> pd.DataFrame:
    """Lay out angles in degrees, as they go into a file.

    Parameters
    ----------
    prediction : Prediction
        Angles of one segment.

    Returns
    -------
    pandas.DataFrame
        ``time_s``, ``sagittal_deg``, ``frontal_deg``, ``transverse_deg``, and
        ``sagittal_std_deg`` etc. where the network knows its error.
    """
    columns = {"time_s": prediction.time_s}
    for k, axis in enumerate(AXES):
        columns[f"{axis}_deg"] = np.degrees(prediction.angles_rad[:, k]).round(6)
    if prediction.std_rad is not None:
        for k, axis in enumerate(AXES):
            columns[f"{axis}_std_deg"] = np.degrees(prediction.std_rad[:, k]).round(6)
    return pd.DataFrame(columns)


def _predict(cfg: DictConfig) -> None:
    target = Path(str(cfg.output))
    files = session_files(cfg.input) if isinstance(cfg.input, DictConfig) else None
    sources = list(files.values()) if files else [Path(str(cfg.input))]
    for source in sources:
        if target.exists() and source.exists() and target.samefile(source):
            raise UserError(f"output: '{target}' is the input, expected another name")
    if files is not None:
        predict_files(cfg, files, target)
    else:
        _predict_one(cfg, sources[0], target)


def _predict_one(cfg: DictConfig, source: Path, target: Path) -> None:
    check_suffix(target)
    still_s = interval_s(cfg.still_s, "still_s")
    recording = read_recording(source, layout=layout_of(cfg))
    prediction = predict(
        recording,
        load_or_pretrained(cfg.checkpoint).method(cfg.smoothing),
        frame=cfg.frame,
        side=cfg.side,
        # one segment's zero is rarely known; a session says itself whether it begins at rest
        start_pose="unknown" if cfg.start_pose == "auto" else cfg.start_pose,
        remove_bias=cfg.remove_bias,
        still_s=still_s,
        where=str(source),
    )
    write_angles(table_of(prediction), target)
    print(*prediction.notes, sep="\n")
    n_angles = int(np.isfinite(prediction.angles_rad).all(axis=1).sum())
    print(f"{target}: {n_angles} of {len(prediction.time_s)} samples with angles")


main = command("predict", keeps_run=False)(_predict)

if __name__ == "__main__":
    main()
