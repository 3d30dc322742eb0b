"""Tables of a session's angles: over time, per stride, and over the gait cycle."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from narx.gait.strides import POINTS, normalised_strides
from narx.inference.session import SessionPrediction
from narx.kinematics.segment_angles import AXES
from narx.recordings.trial import side_of
from narx.types import FloatArray


def angle_table(session: SessionPrediction) -> pd.DataFrame:
    """Tabulate the angles over time.

    Parameters
    ----------
    session : SessionPrediction
        Angles of segments and joints.

    Returns
    -------
    pandas.DataFrame
        ``time_s``, then ``<segment or joint>_<axis>_deg``, then the standard deviations
        ``<...>_<axis>_std_deg`` where available, and ``<segment>_quality``.
    """
    columns: dict[str, FloatArray] = {"time_s": session.time_s}
    for suffix, values in (("deg", session.angles_rad), ("std_deg", session.std_rad)):
        for name, angles in values.items():
            for k, axis in enumerate(AXES):
                columns[f"{name}_{axis}_{suffix}"] = np.degrees(angles[:, k]).round(6)
    quality = {f"{name}_quality": values for name, values in session.quality.items()}
    return pd.DataFrame(columns).assign(**quality)


def strides_of(session: SessionPrediction) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    """Split the angles of every segment and joint of a leg at its foot contacts.

    Parameters
    ----------
    session : SessionPrediction
        Angles and contacts.

    Yields
    ------
    name : str
        Segment or joint.
    contacts_s : ndarray, shape (S + 1,)
        Foot contacts, s.
    strides_deg : ndarray, shape (S, 101, 3)
        Angles over 0-100 % of each stride, degrees; NaN if a stride is incomplete.
    """
    for name, angles in session.angles_rad.items():
        contacts = session.contacts_s.get(side_of(name) or "")
        if contacts is not None and len(contacts) > 1:
            yield name, contacts, normalised_strides(session.time_s, np.degrees(angles), contacts)


def stride_table(session: SessionPrediction) -> pd.DataFrame:
    """Tabulate the parameters of every stride.

    Parameters
    ----------
    session : SessionPrediction
        Angles and contacts.

    Returns
    -------
    pandas.DataFrame
        One row per segment or joint, axis and complete stride: start and duration, cadence in
        steps per minute, range of motion, maximum and minimum angle in degrees.
    """
    rows = []
    for name, contacts, strides in strides_of(session):
        durations = np.diff(contacts)
        for stride in np.flatnonzero(np.isfinite(strides).all(axis=(1, 2))):
            for k, axis in enumerate(AXES):
                angles = strides[stride, :, k]
                rows.append(
                    {
                        "name": name,
                        "axis": axis,
                        "stride": int(stride) + 1,
                        "begin_s": round(float(contacts[stride]), 3),
                        "duration_s": round(float(durations[stride]), 3),
                        "cadence_steps_per_min": round(120.0 / float(durations[stride]), 1),
                        "range_deg": round(float(np.ptp(angles)), 3),
                        "maximum_deg": round(float(angles.max()), 3),
                        "minimum_deg": round(float(angles.min()), 3),
                    }
                )
    columns = [
        "name", "axis", "stride", "begin_s", "duration_s", "cadence_steps_per_min",
        "range_deg", "maximum_deg", "minimum_deg",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def cycle_table(session: SessionPrediction) -> pd.DataFrame:
    """Average the angles over the gait cycle.

    Parameters
    ----------
    session : SessionPrediction
        Angles and contacts.

    Returns
    -------
    pandas.DataFrame
        One row per segment or joint, axis and percent of the cycle: mean and standard deviation
        over strides, degrees, and the number of strides.
    """
    frames = []
    for name, _, strides in strides_of(session):
        whole = strides[np.isfinite(strides).all(axis=(1, 2))]
        if not len(whole):
            continue
        for k, axis in enumerate(AXES):
            frames.append(
                pd.DataFrame(
                    {
                        "name": name,
                        "axis": axis,
                        "percent": np.linspace(0.0, 100.0, POINTS),
                        "mean_deg": whole[:, :, k].mean(axis=0).round(4),
                        "sd_deg": whole[:, :, k].std(axis=0).round(4),
                        "n_strides": len(whole),
                    }
                )
            )
    columns = ["name", "axis", "percent", "mean_deg", "sd_deg", "n_strides"]
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=columns)
