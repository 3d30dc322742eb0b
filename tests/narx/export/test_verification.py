"""What is compared before an export is written, and the numbers that exports are made of."""

import numpy as np
import pytest

from narx.errors import UserError
from narx.export.tracker_numbers import upper_part
from narx.export.verification import (
    TOLERANCE_RAD,
    largest_difference_rad,
    refuse_above_tolerance,
    signals,
    walk,
)
from narx.inference.stream import OrientationStream
from narx.kinematics.segment_angles import gyroscope_xyz


@pytest.fixture
def exact(checkpoint):
    """An export that is the package itself."""

    def run(inputs, interval_s, start):
        stream = OrientationStream(checkpoint.method(), 25.0, n_sensors=2, initial_angles_rad=start)
        return stream.update_block(inputs, np.cumsum(interval_s, axis=1)).angles_rad.copy()

    return run


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_the_largest_difference_of_either_start_counts(checkpoint, exact):
    assert largest_difference_rad(checkpoint, exact, float) == 0.0
    for known, off in ((False, 0.25), (True, -0.125)):

        def wrong(inputs, interval_s, start, known=known, off=off):
            angles = exact(inputs, interval_s, start)
            if (start is not None) == known:
                there = np.argwhere(np.isfinite(angles))
                angles[tuple(there[len(there) // 2])] += off
            return angles

        assert largest_difference_rad(checkpoint, wrong, float) == pytest.approx(abs(off))


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
@pytest.mark.parametrize("lacks", ["export", "package"])
def test_an_angle_that_one_of_the_two_lacks_is_refused(checkpoint, exact, lacks):
    def wrong(inputs, interval_s, start):
        angles = exact(inputs, interval_s, start)
        same = np.isfinite(angles) if lacks == "export" else np.isnan(angles)
        angles[tuple(np.argwhere(same)[0])] = np.nan if lacks == "export" else 0.0
        return angles

    difference = largest_difference_rad(checkpoint, wrong, float)
    assert np.isnan(difference)
    with pytest.raises(UserError, match="format=c: the export differs from the package by nan"):
        refuse_above_tolerance(difference, 1.0, "c")


def test_the_tolerance_itself_is_accepted():
    for tolerance in TOLERANCE_RAD.values():
        refuse_above_tolerance(tolerance, tolerance, "c")
        with pytest.raises(UserError, match="no file was written"):
            refuse_above_tolerance(np.nextafter(tolerance, 1.0), tolerance, "c")
    # below what a plot or a clinic would show, and below the digits that are written to files
    assert np.degrees(TOLERANCE_RAD["float"]) < 0.01
    assert np.degrees(TOLERANCE_RAD["double"]) < 1e-6


def test_the_walk_turns_as_its_gyroscope_says_and_carries_gravity():
    time_s = np.arange(0.0, 16.0, 0.01)
    inputs = walk(time_s)
    force = inputs[:, 3:]
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), 9.81)
    bias = np.radians([0.4, -0.3, 0.2])
    rate = gyroscope_xyz(inputs[:, :3] - bias)
    # a direction that is fixed in space turns the other way in the sensor: f' = f x w
    change = np.gradient(force, 0.01, axis=0)
    expected = np.cross(force, rate)
    # but for the corners of its ramps
    off = np.abs(change - expected).max(axis=1)
    assert np.percentile(off, 95) < 0.02 * np.abs(expected).max()


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_the_signals_have_losses_and_uneven_intervals(checkpoint):
    inputs, interval_s = signals(checkpoint)
    missing = np.isnan(inputs).any(axis=2)
    assert (missing.mean(axis=1) > 0.01).all()
    np.testing.assert_array_equal(interval_s[0], 0.04)
    assert 0.04 * 0.7 <= interval_s[1].min() < interval_s[1].max() <= 0.04 * 1.3


@pytest.mark.parametrize("rate_hz", [25.0, 94.3, 100.0, 148.148])
def test_multiples_of_the_upper_part_of_an_interval_are_exact_in_float(rate_hz):
    upper = upper_part(1.0 / rate_hz)
    assert 0.0 <= 1.0 / rate_hz - upper < 2.0**-11 / rate_hz
    multiples = np.arange(4097) * upper
    np.testing.assert_array_equal(multiples.astype(np.float32).astype(float), multiples)
