"""Break down the knee angle error on simulated gait by its sources.

python -m experiments.error_budget

The *floor* is the error, relative to the markers, of a method that is given the exact orientation
of every sensor: what remains is due to soft tissue, landmarks and calibration. It is compared with
the network.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from omegaconf import DictConfig
from scipy.spatial.transform import Rotation
from tqdm import tqdm

from narx.calibration.calibrate import calibrate, signals_in_frame
from narx.datasets.simulated_gait import SimulatedGait
from narx.experiments.command import command, run_directory
from narx.experiments.runs.record import environment, seed_everything, write_json
from narx.experiments.tables.table import Table, as_markdown
from narx.files import atomic_path
from narx.inference.pretrained import load_or_pretrained
from narx.kinematics.joint_angles import grood_suntay
from narx.kinematics.rotations import compose
from narx.kinematics.segment_angles import (
    AXES,
    mirror_quaternion,
    orientation_from_angles,
)
from narx.method import OrientationMethod
from narx.recordings.trial import side_of
from narx.simulation.true_motion import TrueMotion
from narx.types import FloatArray

SIDES = ("right", "left")
_ESTIMATES = ("floor", "narx")


def exact_frame(truth: TrueMotion, segment: str) -> Rotation:
    """Return the true mounting of a sensor on its bone.

    Parameters
    ----------
    truth : TrueMotion
        True motion of a trial that starts in the calibration posture, in which no tissue is
        displaced.
    segment : str
        Which sensor.

    Returns
    -------
    Rotation
        Maps vectors in the sensor frame to the (not mirrored) anatomical frame.
    """
    bone, sensor = (
        Rotation.from_quat(of[segment][0], scalar_first=True)
        for of in (truth.segment_wxyz, truth.sensor_wxyz)
    )
    return bone.inv() * sensor


def exactly_tracked(sensor_wxyz: FloatArray, frame: Rotation, segment: str) -> FloatArray:
    """Return the estimate of a method without errors of its own.

    Parameters
    ----------
    sensor_wxyz : ndarray, shape (N, 4)
        True orientation of the sensor.
    frame : Rotation
        Calibrated rotation from sensor to anatomical frame.
    segment : str
        Name; a left one is mirrored.

    Returns
    -------
    ndarray, shape (N, 4)
        Quaternions w, x, y, z of the anatomical frame, starting at zero as methods do.
    """
    sensor = Rotation.from_quat(sensor_wxyz, scalar_first=True)
    wxyz = compose(frame * sensor[0].inv(), sensor, frame.inv()).as_quat(scalar_first=True)
    return mirror_quaternion(wxyz) if side_of(segment) == "left" else np.asarray(wxyz)


def knee_errors(
    source: SimulatedGait, calibration: str, method: OrientationMethod, skip_s: float
) -> Iterator[dict[str, object]]:
    """Compute the errors of the floor and of a method on every knee of a source.

    Parameters
    ----------
    source : SimulatedGait
        Walks.
    calibration : str
        Mode of `narx.calibration.calibrate.calibrate`, or ``exact``.
    method : OrientationMethod
        Method to compare with the floor.
    skip_s : float
        Length of the start of each trial that is not scored, s.

    Yields
    ------
    dict
        ``seed``, ``subject``, ``condition``, ``side``, ``estimate`` (``floor`` or ``narx``) and the
        root mean square error in degrees of each of `AXES`, mean error included.
    """
    for trial in source:
        truth = source.truth(trial.subject, trial.condition, trial.trial)
        calibrated = calibrate(trial, "auto" if calibration == "exact" else calibration)  # type: ignore[arg-type]
        scored = trial.time_s - trial.time_s[0] >= skip_s
        for side in SIDES:
            names = [f"{kind}_{side}" for kind in ("thigh", "shank")]
            frames = {
                name: exact_frame(truth, name)
                if calibration == "exact"
                else calibrated[name].sensor_to_anatomical
                for name in names
            }
            said = {
                "floor": [exactly_tracked(truth.sensor_wxyz[n], frames[n], n) for n in names],
                "narx": [
                    orientation_from_angles(
                        method.estimate(
                            signals_in_frame(trial, n, frames[n], calibrated[n].static_bias_rad_s)
                        )
                    )
                    for n in names
                ],
            }
            reference = grood_suntay(*(calibrated[n].reference_wxyz for n in names))  # type: ignore[arg-type]
            for estimate in _ESTIMATES:
                error = np.degrees(reference - grood_suntay(*said[estimate]))[scored]
                rmse = np.sqrt(np.nanmean(error**2, axis=0))
                yield {
                    "seed": source.seed,
                    "subject": trial.subject,
                    "condition": trial.condition,
                    "side": side,
                    "estimate": estimate,
                } | dict(zip(AXES, rmse, strict=True))


def budget_tables(errors: pd.DataFrame) -> list[Table]:
    """Tabulate the variants, and the knees of the first variant.

    Parameters
    ----------
    errors : pandas.DataFrame
        Rows of `knee_errors` with a column ``variant``, in the order in which to show them.

    Returns
    -------
    list of Table
        Mean RMSE per variant; frontal RMSE of every knee (mean over speeds) in the first variant.
    """
    variants = list(dict.fromkeys(errors["variant"]))
    mean = pd.DataFrame(
        {
            f"{estimate} {axis}": of_one.groupby("variant")[axis].mean()
            for estimate in _ESTIMATES
            for of_one in [errors[errors["estimate"] == estimate]]
            for axis in AXES
        }
    ).loc[variants]
    mean.index.name = "variant"
    first = errors[errors["variant"] == variants[0]]
    who = first["subject"] + ", seed " + first["seed"].astype(str)
    which = first["estimate"] + " " + first["side"]
    knees = first.groupby([who.rename("subject"), which.rename("knee")])["frontal"].mean()
    knees = knees.unstack("knee")
    return [
        Table("Knee RMSE (°)", mean, dict.fromkeys(mean.columns, 2)),
        Table(f"Frontal knee RMSE (°) with {variants[0]}", knees, dict.fromkeys(knees.columns, 2)),
    ]


def _error_budget(cfg: DictConfig) -> None:
    seed_everything(cfg.seed)
    directory = run_directory()
    method = load_or_pretrained(cfg.checkpoint).method()
    rows: list[dict[str, object]] = []
    for name, variant in tqdm(cfg.variants.items(), desc="variants", disable=None):
        for seed in cfg.seeds:
            source = SimulatedGait(
                subjects=tuple(cfg.subjects),
                treadmill_duration_s=cfg.duration_s,
                sampling_rate_hz=cfg.sampling_rate_hz,
                without=tuple(variant.without),
                seed=seed,
            )
            mode = variant.calibration
            rows += [
                {"variant": name} | row for row in knee_errors(source, mode, method, cfg.skip_s)
            ]
    errors = pd.DataFrame(rows)
    with atomic_path(directory / "error_budget.csv") as temporary:
        errors.to_csv(temporary, index=False)
    write_json(environment(cfg.seed, {}), directory / "environment.json")
    text = as_markdown(budget_tables(errors))
    with atomic_path(directory / "error_budget.md") as temporary:
        temporary.write_text(text + "\n")
    print(text)
    print(f"\nerror_budget.csv and error_budget.md: {directory}")


main = command("error_budget")(_error_budget)

if __name__ == "__main__":
    main()
