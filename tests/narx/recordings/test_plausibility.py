"""Plausibility checks on input: what is accepted and what is refused."""

import numpy as np
import pytest

from narx.errors import RecordingError
from narx.recordings.one_clock import at_gyroscope_times
from narx.recordings.plausibility import admit, check_gravity
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording


@pytest.fixture(scope="module")
def walk(device_walk):
    return device_walk(50.0, 30.0)


def test_a_walk_passes_unchanged(walk):
    admitted = admit(walk.recording(), "w")
    np.testing.assert_array_equal(admitted.gyroscope_rad_s, walk.gyroscope_rad_s)
    np.testing.assert_array_equal(admitted.time_s, walk.time_s)
    assert admitted.notes == ()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda w: {"gyroscope_rad_s": np.degrees(w.gyroscope_rad_s)}, "9957 deg/s, beyond any"),
        # a shuffling gait, scaled, stays within the accepted rates, but its swing is implausible
        (lambda w: {"gyroscope_rad_s": 15 * w.gyroscope_rad_s}, "swings by .* no leg does"),
        (lambda w: {"gyroscope_rad_s": np.radians(w.gyroscope_rad_s)}, "rad/s in a column of deg"),
        (lambda w: {"gyroscope_rad_s": np.round(w.gyroscope_rad_s * 938.7)}, "raw counts"),
        (lambda w: {"gyroscope_rad_s": w.gyroscope_rad_s * np.nan}, "no two gyroscope samples"),
        (lambda w: {"time_s": w.time_s + 1e7 * (w.time_s > 10)}, "1e.07 s without a sample after"),
        (lambda w: {"time_s": w.time_s + 1e9 * (w.time_s > 10)}, "1e.09 s without a sample after"),
        (lambda w: {"time_s": 1000 * w.time_s}, "milliseconds"),
        (lambda w: {"time_s": w.time_s / 60.0}, "are the times in minutes"),
        (lambda w: {"time_s": 10.0 * w.time_s}, "are the times in tenths of a second"),
        (lambda w: {"time_s": w.time_s / 3600.0}, "hours"),
        (lambda w: {"time_s": w.time_s / 86400.0}, "days"),
    ],
)
def test_implausible_leg_motion_is_refused(walk, change, message):
    with pytest.raises(RecordingError, match=f"^w: .*{message}") as caught:
        admit(walk.recording(**change(walk)), "w")
    assert "\n" not in str(caught.value)


def test_a_gap_of_hours_is_within_one_recording(walk):
    """3 million ticks of the clock, of 5 million."""
    time_s = walk.time_s + 6e4 * (walk.time_s > 10)
    np.testing.assert_array_equal(admit(walk.recording(time_s=time_s), "w").time_s, time_s)


@pytest.mark.parametrize("rate_hz", [10.0, 20.0])
def test_a_slow_sensor_is_not_taken_for_times_in_tenths(device_walk, rate_hz):
    walk = device_walk(rate_hz, 60.0)
    assert admit(walk.recording(), "w").notes == ()


def test_who_stands_is_not_taken_for_a_walker_in_another_unit(walk):
    sway = np.radians(np.random.default_rng(0).normal(0.0, 0.5, (1500, 3)))
    assert admit(walk.recording(gyroscope_rad_s=sway), "w").notes == ()


def test_a_slower_sensor_gets_its_own_clock(device_walk, walk):
    held = np.repeat(walk.gyroscope_rad_s, 4, axis=0)
    fast = np.arange(len(held)) / 200.0
    admitted = admit(walk.recording(time_s=fast, gyroscope_rad_s=held,
                                    accelerometer_m_s2=held * np.nan), "w")  # fmt: skip
    moving = admitted.time_s > 5.0
    np.testing.assert_allclose(np.diff(admitted.time_s[moving]), 0.02, atol=1e-9)
    assert "a slower sensor than the file's clock" in admitted.notes[0]


def test_impossible_accelerations_are_missing(walk):
    force = walk.accelerometer_m_s2.copy()
    force[10], force[20, 1], force[30] = 0.0, 1e30, np.nan
    admitted = admit(walk.recording(accelerometer_m_s2=force), "w")
    assert set(np.flatnonzero(np.isnan(admitted.accelerometer_m_s2).any(axis=1))) == {10, 20, 30}
    assert len(admitted.notes) == 2


@pytest.mark.parametrize(("impossible", "refused"), [(7, False), (8, True)])
def test_half_a_per_cent_beyond_any_gyroscope_is_refused(walk, impossible, refused):
    rate = walk.gyroscope_rad_s.copy()
    rate[300 : 300 + 40 * impossible : 40, 0] = np.radians(4600.0) + 1e-6 * np.arange(impossible)
    if refused:
        with pytest.raises(RecordingError, match="4600 deg/s, beyond any gyroscope"):
            admit(walk.recording(gyroscope_rad_s=rate), "w")
        return
    (note,) = admit(walk.recording(gyroscope_rad_s=rate), "w").notes
    assert note.startswith(f"{impossible} samples beyond any gyroscope")


@pytest.mark.parametrize("share", [0.05, 0.6])
def test_one_impossible_value_is_a_code_for_missing_samples(walk, share):
    rate = walk.gyroscope_rad_s.copy()
    coded = np.random.default_rng(0).random(len(rate)) < share
    rate[coded] = np.radians(-9999.0)
    if share > 0.5:
        with pytest.raises(RecordingError, match="9999 deg/s, beyond any gyroscope"):
            admit(walk.recording(gyroscope_rad_s=rate), "w")
        return
    admitted = admit(walk.recording(gyroscope_rad_s=rate), "w")
    np.testing.assert_array_equal(np.isnan(admitted.gyroscope_rad_s).all(axis=1), coded)


@pytest.mark.parametrize(
    ("factor", "guess"),
    [(1 / GRAVITY_M_S2, "g"), (1e3 / GRAVITY_M_S2, r"mg or cm/s\^2"), (100.0, r"mg or cm/s\^2"),
     (GRAVITY_M_S2, r"m/s\^2, not g"), (0.3, "gravity subtracted"), (1671.0, "raw counts")],
)  # fmt: skip
def test_an_accelerometer_in_another_unit_is_named(walk, factor, guess):
    check_gravity(walk.accelerometer_m_s2, "w")
    with pytest.raises(RecordingError, match=rf"^w: .*expected about 9.8; {guess}\?$"):
        check_gravity(factor * walk.accelerometer_m_s2, "w")


@pytest.mark.parametrize("together", [True, False])
def test_two_rates_on_one_axis(device_walk, together):
    """Gyroscope at 50 Hz; accelerometer at 25 Hz in the same rows, or at 40 Hz in its own."""
    own = np.arange(1500) / 50.0
    other = own[::2] if together else np.arange(1200) / 40.0 + 0.003
    time = np.union1d(own, other)
    walk = device_walk(time_s=time)
    gyroscope = np.where(np.isin(time, own)[:, None], walk.gyroscope_rad_s, np.nan)
    force = np.where(np.isin(time, other)[:, None], walk.accelerometer_m_s2, np.nan)
    merged = at_gyroscope_times(walk.recording(gyroscope_rad_s=gyroscope, accelerometer_m_s2=force))
    np.testing.assert_array_equal(merged.time_s, own)
    assert np.isfinite(merged.gyroscope_rad_s).all()
    truth = device_walk(time_s=own).accelerometer_m_s2
    np.testing.assert_allclose(merged.accelerometer_m_s2[1:-2], truth[1:-2], atol=0.15)
    assert "gyroscope at 50 Hz and accelerometer at" in merged.notes[0]


def test_single_missing_samples_are_no_other_rate(walk):
    force = walk.accelerometer_m_s2.copy()
    force[::10] = np.nan
    recording = walk.recording(accelerometer_m_s2=force)
    assert at_gyroscope_times(recording) is recording


@pytest.mark.parametrize("n_sensors", [2, 3])
def test_rows_of_several_sensors_are_refused(device_walk, n_sensors):
    walk = device_walk(50.0, 20.0)
    axes = ([0, 1, 2], [1, 0, 2], [2, 1, 0])[:n_sensors]
    rate = np.stack([walk.gyroscope_rad_s[:, order] for order in axes], axis=1).reshape(-1, 3)
    time = np.arange(len(rate)) / (50.0 * n_sensors)
    several = ImuRecording("s", time, rate, np.full_like(rate, np.nan))
    with pytest.raises(RecordingError, match=f"the rows of {n_sensors} sensors"):
        admit(several, "w")


@pytest.mark.parametrize("rate_hz", [12.5, 25.0, 50.0, 100.0])
def test_one_sensor_is_not_taken_for_several(device_walk, rate_hz):
    walk = device_walk(rate_hz, 20.0)
    noise = np.random.default_rng(0).normal(0.0, 0.3, walk.gyroscope_rad_s.shape)
    admit(walk.recording(gyroscope_rad_s=walk.gyroscope_rad_s + noise), "w")
