"""Disturb simulated walks by handling, slips, turns and pauses, and print the network's errors.

python docs/disturbances.py [--first N]

The shipped network estimates the right thigh and shank of six drawn walkers at three speeds, by
default the first six. Makes tables of docs/generalisation.md.
"""

import argparse
from typing import Any

import numpy as np
import pandas as pd

from narx.calibration.calibrate import calibrate
from narx.datasets import SimulatedGait
from narx.experiments.tables.table import Table, as_markdown
from narx.inference.pretrained import pretrained
from narx.inference.stream import Quality
from narx.types import FloatArray

SPEEDS = ("slow", "normal", "fast")
# options of the walk, and the part of the recording that is scored, s
CASES: dict[str, tuple[dict[str, Any], float, float]] = {
    "undisturbed, 35 to 45 s": ({}, 35.0, 45.0),
    "running, 35 to 45 s": ({"conditions": ("running",)}, 35.0, 45.0),
    "in a hand for 10 s, 5 to 15 s of walking": ({"handling_s": 10.0}, 19.0, 29.0),
    "in a hand for 10 s, 15 to 45 s of walking": ({"handling_s": 10.0}, 29.0, 59.0),
    "slip of 10° at 30 s, 5 to 15 s later": ({"slips_s": [30.0], "slip_deg": 10.0}, 35.0, 45.0),
    "slip of 20° at 30 s, 5 to 15 s later": ({"slips_s": [30.0]}, 35.0, 45.0),
    "slip of 40° at 30 s, 5 to 15 s later": ({"slips_s": [30.0], "slip_deg": 40.0}, 35.0, 45.0),
    "three turns of 180° in 4 s, 22 to 60 s": (
        {"turns_s": [[22.0, 26.0], [32.0, 36.0], [42.0, 46.0]]},
        22.0,
        60.0,
    ),
    "standing for 12 s, 10 to 20 s later": ({"pauses_s": [[28.0, 40.0]]}, 50.0, 60.0),
    "sitting for 12 s, 10 to 20 s later": (
        {"pauses_s": [[28.0, 40.0]], "sits": True},
        50.0,
        60.0,
    ),
}


def row(first: int, options: dict[str, Any], begin_s: float, end_s: float) -> dict[str, object]:
    """Errors of a case, sagittal / frontal: mean over segments, and the worst one."""
    method = pretrained().method()
    rmse, deviation, inside, covered, starting, doubtful = [], [], [], [], [], []
    for number, speed in enumerate(SPEEDS):
        walkers = tuple(f"V{first + 2 * number + i}" for i in range(2))
        source = SimulatedGait(
            subjects=walkers,
            treadmill_duration_s=62.0,
            sampling_rate_hz=100.0,
            segments=("thigh_right", "shank_right"),
            **{"conditions": (speed,), **options},
        )
        for trial in source.select():
            for segment in calibrate(trial).values():
                found = method.run(segment.signals)
                assert segment.reference_angles_rad is not None
                assert found.std_rad is not None
                part = slice(*(round(s * 100.0) for s in (begin_s, end_s)))
                error = (segment.reference_angles_rad - found.angles_rad)[part, :2]
                there = np.isfinite(error).all(axis=1)
                error_deg, std = np.degrees(error[there]), found.std_rad[part, :2][there]
                rmse.append(np.sqrt(np.mean(error_deg**2, axis=0)))
                deviation.append(error_deg.std(axis=0))
                held, quality = np.abs(error[there]) < 1.96 * std, found.quality[part][there]
                marked = np.isin(quality, (Quality.STARTING, Quality.DOUBTFUL))[:, None]
                inside.append(np.mean(held, axis=0))
                covered.append(np.mean(held | marked, axis=0))
                starting.append(np.mean(found.quality[part] == Quality.STARTING))
                doubtful.append(np.mean(found.quality[part] == Quality.DOUBTFUL))
    return {
        "RMSE": _both(np.mean(rmse, axis=0)),
        "worst segment": _both(np.max(rmse, axis=0)),
        "SD of the error": _both(np.mean(deviation, axis=0)),
        "95 % band": _shares(np.mean(inside, axis=0)),
        "in the 95 % band or marked": _shares(np.mean(covered, axis=0)),
        "start-up or idle, %": f"{100.0 * np.mean(starting):.0f}",
        "doubtful, %": f"{100.0 * np.mean(doubtful):.0f}",
    }


def _both(values_deg: FloatArray) -> str:
    return " / ".join(f"{value:.1f}" for value in values_deg)


def _shares(values: FloatArray) -> str:
    return " / ".join(f"{100.0 * value:.0f}" for value in values)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1, help="number of the first drawn walker")
    first = parser.parse_args().first
    rows = {name: row(first, *case) for name, case in CASES.items()}
    frame = pd.DataFrame.from_dict(rows, orient="index").rename_axis("walk")
    print(as_markdown([Table("Disturbed walks, sagittal / frontal (°)", frame)]))


if __name__ == "__main__":
    main()
