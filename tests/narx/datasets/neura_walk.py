"""A made-up walk in the format of the NeuRA sample: stand, walk, turn, walk, stand."""

from pathlib import Path

import numpy as np
import pandas as pd
import scipy.io
from scipy.spatial.transform import Rotation

NAME = "S99-Trial-Walk-1"
SENSORS = {
    "thigh_right": "00B40C3C", "thigh_left": "00B40C45",
    "shank_right": "00B40C35", "shank_left": "00B40BA5",
}  # fmt: skip
_DURATION_S, _STAND_S = 14.0, 2.0
_LOWER, _LATERAL = ("KJC", "AJC"), ("KNE", "ANK")


def _orientation(time: np.ndarray, segment: str) -> Rotation:
    """From the segment, x forward and z up, to the room."""
    walk = np.clip(time - _STAND_S, 0.0, _DURATION_S - 2 * _STAND_S)
    ramp = np.clip(np.minimum(walk, _DURATION_S - 2 * _STAND_S - walk), 0.0, 1.0)
    phase = 2 * np.pi * 0.9 * walk + np.pi * ("left" in segment) - 0.9 * ("shank" in segment)
    heading = np.pi * np.clip((time - 6.0) / 2.0, 0.0, 1.0)
    swing = -0.4 * ramp * np.sin(phase + 0.35 * np.sin(phase))
    return Rotation.from_euler("ZXY", np.column_stack([heading, 0.1 * ramp * np.sin(phase), swing]))


def points_mm() -> dict[str, np.ndarray]:
    """Joint centres and markers beside them.

    Returns
    -------
    dict of str to ndarray, shape (N, 3)
        By name, in the room, mm.
    """
    time = np.arange(0.0, _DURATION_S, 0.01)
    points = {}
    for side, left in (("right", -50.0), ("left", 50.0)):
        hip = np.tile([0.0, 2 * left, 1000.0], (len(time), 1))
        points[f"{side[0].upper()}HJC"] = hip
        for k, part in enumerate(("thigh", "shank")):
            turn = _orientation(time, f"{part}_{side}")
            hip = hip + turn.apply([0.0, 0.0, -400.0])
            points[f"{side[0].upper()}{_LOWER[k]}"] = hip
            points[f"{side[0].upper()}{_LATERAL[k]}"] = hip + turn.apply([0.0, left, 0.0])
    return points


def write_neura(root: Path, points: dict[str, np.ndarray]) -> None:
    """Write the walk.

    Parameters
    ----------
    root : pathlib.Path
        Folder for ``rawimu`` and ``rawvicon``.
    points : dict of str to ndarray, shape (N, 3)
        As of `points_mm`.
    """
    time = np.arange(0.0, _DURATION_S, 0.01)
    for folder in ("rawimu", "rawvicon"):
        (root / folder).mkdir(parents=True)
    for segment, number in SENSORS.items():
        before, after = (_orientation(time + step, segment) for step in (-1e-4, 1e-4))
        rate = (before.inv() * after).as_rotvec() / 2e-4
        force = _orientation(time, segment).inv().apply([0.0, 0.0, 9.81])
        table = pd.DataFrame(
            np.column_stack([force, rate]),
            columns=[f"{kind}_{axis}" for kind in ("Acc", "Gyr") for axis in "XYZ"],
        )
        table.insert(0, "PacketCounter", (65_000 + np.arange(len(time))) % 2**16)
        path = root / "rawimu" / f"{NAME}-000_{number}.txt"
        path.write_text("// Update Rate: 100.0Hz\n" + table.to_csv(index=False))
    scipy.io.savemat(root / "rawvicon" / f"{NAME}.mat", points)
