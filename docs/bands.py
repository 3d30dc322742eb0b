"""Shares of errors within the predicted bands, and of samples that are marked, by motion.

python docs/bands.py DIR [--hour]

DIR holds `smartphone_pocket`. The shipped network estimates every walk of two people; the factor on
the standard deviation of one is measured on the pocket walks of the other. With `--hour` two
simulated people walk for an hour from a known start. Makes tables of docs/generalisation.md.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from narx.calibration.calibrate import calibrate
from narx.datasets import SimulatedGait, SmartphonePocket
from narx.experiments.tables.table import Table, as_markdown
from narx.inference.narx_method import NarxMethod
from narx.inference.pretrained import pretrained
from narx.inference.stream import Quality
from narx.recordings.trial import Trial
from narx.types import BoolArray, FloatArray

START_S, SETTLED_S, HOUR_S = 10.0, 5.0, 3600.0
LEVELS = {"68 %": 0.994, "95 %": 1.96}
MARKED = (Quality.STARTING, Quality.DOUBTFUL)


@dataclass(frozen=True)
class Walk:
    """A trial: its names, and of every sample the time, |error| / SD (N, 2) and quality."""

    subject: str
    motion: str
    time_s: FloatArray
    ratio: FloatArray
    quality: FloatArray


def estimated(method: NarxMethod, trial: Trial) -> Iterator[Walk]:
    """Yield the segments of a trial."""
    for segment in calibrate(trial).values():
        found = method.run(segment.signals)
        assert segment.reference_angles_rad is not None
        assert found.std_rad is not None
        ratio = np.abs(segment.reference_angles_rad - found.angles_rad) / found.std_rad
        there = np.isfinite(ratio[:, :2]).all(axis=1)
        time_s = np.arange(len(ratio)) * segment.signals.interval_s
        motion = trial.condition.partition("_")[2] or trial.condition
        yield Walk(trial.subject, motion, time_s[there], ratio[there, :2], found.quality[there])


def scale_of(ratio: FloatArray) -> FloatArray:
    """Factor with which the two bands hold their shares, as in training."""
    bands = np.quantile(ratio, [0.68, 0.95], axis=0) / np.array([*LEVELS.values()])[:, None]
    return np.asarray(bands.mean(axis=0))


def scaled(walks: list[Walk]) -> list[Walk]:
    """Multiply the standard deviations by the factor that the other people's pockets need."""
    found = []
    for walk in walks:
        others = [
            one.ratio[one.time_s >= SETTLED_S]
            for one in walks
            if one.subject != walk.subject and one.motion.endswith("Pocket")
        ]
        found.append(replace(walk, ratio=walk.ratio / scale_of(np.concatenate(others))))
    return found


def row(walks: list[Walk], begin_s: float, end_s: float) -> dict[str, object]:
    """Shares in percent, sagittal / frontal: mean over trials, and the range of single ones."""
    cells: dict[str, object] = {"trials": len(walks)}
    parts = [(walk, (walk.time_s >= begin_s) & (walk.time_s < end_s)) for walk in walks]
    for name, limit in LEVELS.items():
        shares = [np.mean(walk.ratio[at] < limit, axis=0) for walk, at in parts]
        cells[f"{name} band"] = _both(np.mean(shares, axis=0))
        low, high = _both(np.min(shares, axis=0)), _both(np.max(shares, axis=0))
        cells[f"{name} band, range"] = f"{low} to {high}"
    marked: list[BoolArray] = [np.isin(walk.quality[at], MARKED) for walk, at in parts]
    either = [
        np.mean((walk.ratio[at] < LEVELS["95 %"]) | flags[:, None], axis=0)
        for (walk, at), flags in zip(parts, marked, strict=True)
    ]
    cells["in the 95 % band or marked"] = _both(np.mean(either, axis=0))
    cells["lowest trial"] = _both(np.min(either, axis=0))
    for name, which in (("start-up or idle", Quality.STARTING), ("doubtful", Quality.DOUBTFUL)):
        shares = [np.mean(walk.quality[at] == which) for walk, at in parts]
        cells[f"{name}, %"] = f"{100 * np.mean(shares):.0f} (at most {100 * np.max(shares):.0f})"
    return cells


def _both(shares: FloatArray) -> str:
    return " / ".join(f"{100.0 * share:.0f}" for share in shares)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data_root", type=Path, help="folder with smartphone_pocket")
    parser.add_argument("--hour", action="store_true", help="also an hour of simulated walking")
    arguments = parser.parse_args()
    method = pretrained().method()
    source = SmartphonePocket(root=arguments.data_root / "smartphone_pocket")
    walks = scaled([walk for trial in source.select() for walk in estimated(method, trial)])
    pockets = [walk for walk in walks if walk.motion.endswith("Pocket")]
    rows = {"pockets, first 10 s": row(pockets, 0.0, START_S)}
    for motion in sorted({walk.motion for walk in walks}):
        chosen = [walk for walk in walks if walk.motion == motion]
        rows[f"{motion}, from 5 s"] = row(chosen, SETTLED_S, np.inf)
    tables = [Table("Bands by motion, sagittal / frontal", _frame(rows))]
    if arguments.hour:
        simulated = SimulatedGait(
            subjects=["S1", "S2"],
            conditions=["normal"],
            treadmill_duration_s=HOUR_S,
            sampling_rate_hz=100.0,
        )
        segments = [walk for trial in simulated.select() for walk in estimated(method, trial)]
        ends = {"first": (SETTLED_S, 300.0), "last": (HOUR_S - 300.0, HOUR_S)}
        hours = {f"{name} five minutes": row(segments, *end) for name, end in ends.items()}
        tables.append(Table("An hour of simulated walking, known start", _frame(hours)))
    print(as_markdown(tables))


def _frame(rows: dict[str, dict[str, object]]) -> pd.DataFrame:
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("part")


if __name__ == "__main__":
    main()
