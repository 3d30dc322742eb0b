"""Plausibility checks on input: what is accepted and what is refused."""

import numpy as np
import pytest

from narx.errors import RecordingError
from narx.recordings.one_clock import at_gyroscope_times
from narx.recordings.plausibility import _strides, admit, check_gravity
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


def _sine(angle_deg, frequency_hz=1.0, bias_deg_s=0.0):
    """A sensor that swings about one axis, with a little noise, at 100 Hz for half a minute."""
    time_s = np.arange(3000) / 100.0
    omega = 2 * np.pi * frequency_hz
    rates = np.radians(angle_deg) * omega * np.outer(np.cos(omega * time_s), [0.0, 1.0, 0.1])
    noise = np.random.default_rng(0).normal(0.0, 1e-4, rates.shape)
    rates = rates + noise + np.radians(bias_deg_s)
    return ImuRecording("s", time_s, rates, np.full_like(rates, np.nan))


@pytest.mark.parametrize(
    ("swing", "message"),
    [
        (_sine(150.0), None),
        (_sine(210.0), "swings by 2.. deg to either side"),
        (_sine(3.0), None),  # 19 deg/s
        (_sine(0.5), r"never turns faster than 3\.2 deg/s"),
        (_sine(0.5, bias_deg_s=5.0), r"never turns faster than 3\.2 deg/s"),
    ],
)
def test_limits_of_the_swing_of_a_leg(swing, message):
    if message is None:
        assert admit(swing, "w").notes == ()
        return
    with pytest.raises(RecordingError, match=message):
        admit(swing, "w")


@pytest.mark.parametrize(("share", "strides"), [(0.58, True), (0.42, False)])
@pytest.mark.parametrize("frequency_hz", [0.9, 0.95])
def test_strides_are_half_of_the_power_in_a_narrow_band(share, strides, frequency_hz):
    rng = np.random.default_rng(0)
    noise = rng.normal(0.0, np.sqrt(0.5 * (1 / share - 1)), (30000, 1))
    swing = np.cos(2 * np.pi * frequency_hz * np.arange(30000) / 50.0)[:, None]
    assert _strides(swing + noise, 0.02) == strides


@pytest.mark.parametrize(("ratio", "refused"), [(2.5, False), (8.0, True)])
def test_rows_of_two_sensors_differ_four_times_as_much_as_those_of_one(ratio, refused):
    """Two noises of SD 0.1 rad/s per axis about means d apart: (d^2 + 6 SD^2) / (6 SD^2)."""
    rates = np.random.default_rng(0).normal(0.0, 0.1, (4000, 3))
    rates[::2, 0] += np.sqrt(6.0 * (ratio - 1.0)) * 0.1
    several = ImuRecording("s", np.arange(4000) / 100.0, rates, np.full_like(rates, np.nan))
    if refused:
        with pytest.raises(RecordingError, match="the rows of 2 sensors"):
            admit(several, "w")
        return
    admit(several, "w")


def test_a_pause_does_not_make_a_wrap_last_longer(walk):
    peak = np.abs(walk.gyroscope_rad_s).max()
    end = np.radians(125.0)
    rates = walk.gyroscope_rad_s * 1.2 * end / peak
    wrapped = (rates + end) % (2.0 * end) - end
    time_s = walk.time_s + 1000.0 * (walk.time_s > 2.0)
    admitted = admit(walk.recording(time_s=time_s, gyroscope_rad_s=wrapped), "w")
    assert any("wrapped around to the other sign, continued" in note for note in admitted.notes)
