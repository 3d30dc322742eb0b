"""Interrupt recorded walks by gaps and pauses, and print how the network recovers.

python docs/interruptions.py DIR

DIR holds `smartphone_pocket`. The shipped network estimates all walks with a phone in a pocket,
each interrupted in several ways. Makes the last tables of docs/generalisation.md.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from narx.calibration.calibrate import calibrate
from narx.datasets import SmartphonePocket
from narx.experiments.tables.table import Table, as_markdown
from narx.inference.filled_gaps import filled_gap_std_rad
from narx.inference.narx_method import NarxMethod
from narx.inference.predict import MAX_GAP_S
from narx.inference.pretrained import pretrained
from narx.method import SegmentSignals
from narx.missing import finite_rows
from narx.recordings.bridging import bridged
from narx.types import BoolArray, FloatArray

# duration of a gap, s, and how many a walk of two minutes has
GAPS = ((0.1, 60), (0.2, 60), (0.3, 60), (0.6, 80), (1.0, 10))
# duration of a pause, s, and by how much the thigh turns in sitting down, degrees
PAUSES = ((10.0, 0.0), (60.0, 0.0), (10.0, 80.0), (60.0, 80.0))
SITTING_DOWN_S = 1.5
# estimates are compared from this time after the start, or after a pause
SETTLED_S = 10.0


def pocket_walks(root: Path) -> Iterator[tuple[SegmentSignals, FloatArray]]:
    """Yield the calibrated signals and the reference angles (rad) of every pocket walk."""
    source = SmartphonePocket(root=root)
    conditions = {str(name) for name in source.index()["condition"]}
    for trial in source.select(condition=sorted(c for c in conditions if c.endswith("Pocket"))):
        (segment,) = calibrate(trial).values()
        assert segment.reference_angles_rad is not None
        yield segment.signals, segment.reference_angles_rad


def with_gaps(signals: SegmentSignals, gap_s: float, n_gaps: int, seed: int) -> SegmentSignals:
    """Lose parts of a recording at random times from the fifth second on."""
    length = round(gap_s / signals.interval_s)
    first = round(5.0 / signals.interval_s)
    begins = np.random.default_rng(seed).integers(first, signals.n_samples - length, n_gaps)
    rates, force = signals.axis_rates_rad_s.copy(), signals.specific_force_m_s2.copy()
    for begin in begins:
        rates[begin : begin + length] = force[begin : begin + length] = np.nan
    return replace(signals, axis_rates_rad_s=rates, specific_force_m_s2=force)


def with_pause(
    signals: SegmentSignals, at: int, pause_s: float, sits_deg: float
) -> tuple[SegmentSignals, int]:
    """Insert a rest before a sample; return the signals, and at which sample walking goes on."""
    n_rest, n_sits = (round(s / signals.interval_s) for s in (pause_s, SITTING_DOWN_S))
    # a raised cosine, whose integral is the angle
    phase = 2.0 * np.pi * (np.arange(n_sits) + 0.5) / n_sits
    turn = np.radians(sits_deg) * (1.0 - np.cos(phase)) / (n_sits * signals.interval_s)
    rest = np.zeros((2 * n_sits + n_rest, 3))
    rest[:n_sits, 0], rest[-n_sits:, 0] = turn, -turn
    rates = np.insert(signals.axis_rates_rad_s, [at] * len(rest), rest, axis=0)
    # a gyroscope alone; the force is not used
    paused = replace(signals, axis_rates_rad_s=rates, specific_force_m_s2=np.full_like(rates, 0.0))
    return paused, at + len(rest)


def estimated(
    method: NarxMethod, signals: SegmentSignals, fills: bool
) -> tuple[FloatArray, FloatArray]:
    """Angles and their standard deviation (rad), as of a stream, or of a file, whose gaps fill."""
    rates = signals.axis_rates_rad_s
    if not fills:
        found = method.run(signals)
        assert found.std_rad is not None
        return found.angles_rad, found.std_rad
    filled = bridged(rates, signals.sampling_rate_hz, MAX_GAP_S)
    found = method.run(replace(signals, axis_rates_rad_s=filled))
    assert found.std_rad is not None
    time_s = np.arange(signals.n_samples) * signals.interval_s
    std = np.hypot(found.std_rad, filled_gap_std_rad(time_s, rates, time_s, MAX_GAP_S))
    missing = ~finite_rows(rates)
    angles = found.angles_rad.copy()
    angles[missing] = std[missing] = np.nan
    return angles, std


def gap_rows(
    method: NarxMethod, walks: list[tuple[SegmentSignals, FloatArray]]
) -> Iterator[dict[str, object]]:
    """Yield the error with gaps of each kind, mean over walks."""
    for gap_s, n_gaps in ((0.0, 0), *GAPS):
        row: dict[str, object] = {"gaps": f"{n_gaps} of {gap_s:g} s" if n_gaps else "none"}
        for name, fills in (("", False), (", filled", True)):
            shares: list[FloatArray] = []
            deviations: list[FloatArray] = []
            for seed, (signals, reference) in enumerate(walks):
                angles, std = estimated(method, with_gaps(signals, gap_s, n_gaps, seed), fills)
                error = np.degrees(reference - angles)[:, :2]
                scored: BoolArray = finite_rows(error)
                scored[: round(SETTLED_S / signals.interval_s)] = False
                ratio = np.abs(error) / np.degrees(std[:, :2])
                deviations.append(error[scored].std(axis=0))
                shares.append(np.mean(ratio[scored] < 1.96, axis=0))
            mean, worst = np.mean(deviations, axis=0), np.max(deviations, axis=0)
            inside = 100.0 * np.mean(shares, axis=0)
            row |= {
                f"SD of the error{name}": f"{mean[0]:.2f} / {mean[1]:.2f}",
                f"worst walk{name}": f"{worst[0]:.1f} / {worst[1]:.1f}",
                f"95 % band{name}": f"{inside[0]:.0f} / {inside[1]:.0f}",
            }
        yield row


def pause_rows(
    method: NarxMethod, walks: list[tuple[SegmentSignals, FloatArray]]
) -> Iterator[dict[str, object]]:
    """Yield the difference from the walk without a pause, ten seconds and more after it."""
    for pause_s, sits_deg in PAUSES:
        differences: list[FloatArray] = []
        for number, (signals, _) in enumerate(walks):
            at = round((40.0 + 1.37 * number) / signals.interval_s)
            paused, resumed = with_pause(signals, at, pause_s, sits_deg)
            off = method.estimate(paused)[resumed:] - method.estimate(signals)[at:]
            begin, end = (round(s / signals.interval_s) for s in (SETTLED_S, 2.0 * SETTLED_S))
            differences.append(np.sqrt(np.nanmean(np.degrees(off[begin:end, :2]) ** 2, axis=0)))
        mean, worst = np.mean(differences, axis=0), np.max(differences, axis=0)
        yield {
            "pause": f"{'sitting' if sits_deg else 'standing'}, {pause_s:g} s",
            "RMS difference": f"{mean[0]:.1f} / {mean[1]:.1f}",
            "worst walk": f"{worst[0]:.1f} / {worst[1]:.1f}",
        }


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data_root", type=Path, help="folder with smartphone_pocket")
    root = parser.parse_args().data_root / "smartphone_pocket"
    method, walks = pretrained().method(), list(pocket_walks(root))
    tables = [
        Table(
            f"Gaps in {len(walks)} pocket walks, sagittal / frontal, from the 10th second (°)",
            pd.DataFrame(gap_rows(method, walks)).set_index("gaps"),
        ),
        Table(
            "Difference from the walk without a pause, sagittal / frontal, "
            "from the 10th to the 20th second after it (°)",
            pd.DataFrame(pause_rows(method, walks)).set_index("pause"),
        ),
    ]
    print(as_markdown(tables))


if __name__ == "__main__":
    main()
