"""Angles of every method on two short motions, as they were: numbers that change are noticed.

``NARX_SNAPSHOTS=write pytest tests/test_snapshots.py`` writes them anew; a change of
``tests/snapshots.csv`` then belongs to the commit whose message says why.
"""

import importlib.util
import os
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch

from narx import baselines
from narx.calibration.calibrate import calibrate
from narx.datasets.simulated_gait import SimulatedGait
from narx.inference.pretrained import load_or_pretrained

FILE = Path(__file__).with_name("snapshots.csv")
WRITE = os.environ.get("NARX_SNAPSHOTS") == "write"
KEYS = ["motion", "method", "time_s"]
ANGLES = ["sagittal_deg", "frontal_deg", "transverse_deg"]
# a thousandth of the smallest error of a method; other processors and libraries differ by 1e-7
TOLERANCE_DEG = 1e-3
METHODS = [getattr(baselines, name) for name in baselines.__all__]
MOTIONS = ("stand_turn_stand", "simulated_walk")


def methods():
    """Every installed method with its defaults, and both modes of the network."""
    found = {
        method.name: method()
        for method in METHODS
        if method.name != "vqf" or importlib.util.find_spec("vqf")
    }
    network = load_or_pretrained(None)
    return found | {
        "narx": network.method(),
        "narx_smoothed": network.method(smoothing=True),
    }


@cache
def walk():
    """Thigh of a simulated walker; the two-point method, which needs standing, starts by hand."""
    source = SimulatedGait(
        subjects=["S1"], conditions=["slow"], treadmill_duration_s=20.0, segments=["thigh_right"]
    )
    return calibrate(source.load("S1", "slow", "1"))["thigh_right"].signals


def signals_of(name, motion):
    if name == "simulated_walk":
        return walk()
    exact = motion(name, 100.0, 40.0).signals
    # a bias of up to half a degree per second, and a known start
    return replace(exact, axis_rates_rad_s=exact.axis_rates_rad_s + np.radians([0.5, -0.3, 0.2]))


def snapshot(motion_name, method_name, signals):
    method = methods()[method_name]
    if method_name == "two_point" and motion_name == "simulated_walk":
        method = baselines.TwoPoint(start_s=1.0, stop_s=18.0)
    angles = np.degrees(method.estimate(signals))
    every = round(1.9 * signals.sampling_rate_hz)
    table = pd.DataFrame(angles[::every].round(5) + 0.0, columns=ANGLES)
    table.insert(0, "time_s", np.arange(len(table)) * every / signals.sampling_rate_hz)
    table.insert(0, "method", method_name)
    table.insert(0, "motion", motion_name)
    return table


@pytest.fixture(scope="module")
def stored(motion):
    if WRITE:
        tables = [
            snapshot(name, method, signals_of(name, motion))
            for name in MOTIONS
            for method in methods()
        ]
        pd.concat(tables).to_csv(FILE, index=False, lineterminator="\n", float_format="%.10g")
    return pd.read_csv(FILE)


@pytest.mark.parametrize("motion_name", MOTIONS)
@pytest.mark.parametrize("method_name", [*(m.name for m in METHODS), "narx", "narx_smoothed"])
def test_angles_equal_the_stored_snapshots(stored, motion, motion_name, method_name):
    if method_name == "vqf":
        pytest.importorskip("vqf")
    expected = stored[(stored.motion == motion_name) & (stored.method == method_name)]
    assert len(expected) >= 10, f"no snapshot of {method_name}; {__doc__}"
    found = snapshot(motion_name, method_name, signals_of(motion_name, motion))
    np.testing.assert_allclose(found["time_s"], expected["time_s"], atol=1e-9)
    np.testing.assert_allclose(
        found[ANGLES].to_numpy(), expected[ANGLES].to_numpy(), atol=TOLERANCE_DEG, err_msg=__doc__
    )


@pytest.mark.concurrency
def test_the_number_of_threads_changes_nothing():
    """For blocks of a stream see tests/narx/inference/test_stream.py."""
    before = torch.get_num_threads()
    try:
        angles = []
        for n_threads in (1, 2, 3):
            torch.set_num_threads(n_threads)
            angles.append(load_or_pretrained(None).method().estimate(walk()))
    finally:
        torch.set_num_threads(before)
    np.testing.assert_array_equal(angles[0], angles[1])
    np.testing.assert_array_equal(angles[0], angles[2])
