"""Angles of a segment from a recording in a CSV file, with a trained network.

python -m experiments.predict checkpoint=PATH input=walk.csv output=angles.csv
"""

from pathlib import Path

import numpy as np
import pandas as pd
from omegaconf import DictConfig, ListConfig

from narx.datasets.csv_recording import read_recording
from narx.errors import UserError
from narx.experiments.command import command
from narx.files import atomic_path
from narx.inference.predict import Prediction, predict
from narx.inference.pretrained import load_or_pretrained
from narx.kinematics.segment_angles import AXES


def _still_s(value: object) -> tuple[float, float] | None:
    if value is None:
        return None
    numbers = list(value) if isinstance(value, ListConfig) else []
    if (
        len(numbers) != 2
        or not all(isinstance(number, int | float) for number in numbers)
        or not numbers[0] < numbers[1]
    ):
        raise UserError(f"still_s is {value}, expected [begin, end] in s")
    return float(numbers[0]), float(numbers[1])


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
    source, target = Path(cfg.input), Path(cfg.output)
    if target.exists() and source.exists() and target.samefile(source):
        raise UserError(f"output: '{target}' is the input, expected another name")
    still_s = _still_s(cfg.still_s)
    recording = read_recording(source)
    prediction = predict(
        recording,
        load_or_pretrained(cfg.checkpoint).method(cfg.smoothing),
        frame=cfg.frame,
        side=cfg.side,
        start_pose=cfg.start_pose,
        remove_bias=cfg.remove_bias,
        still_s=still_s,
        where=str(source),
    )
    try:
        with atomic_path(target) as temporary:
            table_of(prediction).to_csv(temporary, index=False, na_rep="nan")
    except OSError as error:
        raise UserError(f"output: '{target}' cannot be written: {error.strerror}") from error
    print(*prediction.notes, sep="\n")
    n_angles = int(np.isfinite(prediction.angles_rad).all(axis=1).sum())
    print(f"{target}: {n_angles} of {len(prediction.time_s)} samples with angles")


main = command("predict", keeps_run=False)(_predict)

if __name__ == "__main__":
    main()
