import numpy as np
import pytest

from narx.calibration.calibrate import calibrate
from narx.datasets.simulated_gait import SimulatedGait
from narx.errors import UserError
from narx.gait.phases import (
    MEANING,
    PHASES,
    GaitPhases,
    gait_phases,
    smooth_rate_and_derivative,
)
from narx.gait.stride_frequency import stride_frequency_hz

STRIDE_HZ = 0.9
N_STRIDES = 20


def thigh_rate(rate_hz=100.0, noise=0.0, seed=0):
    """Rate of a thigh with a dip at initial contact, and its derivative's zeros by hand."""
    t = np.arange(round(N_STRIDES / STRIDE_HZ * rate_hz)) / rate_hz
    p = 2 * np.pi * STRIDE_HZ * t
    rate = 1.8 * np.cos(p) + 1.1 * np.cos(2 * p) + 0.6 * np.cos(3 * p)
    return rate + np.random.default_rng(seed).normal(0, noise, len(t))


def true_zeros(function, lowest, highest):
    p = np.linspace(lowest, highest, 200001)
    values = function(p)
    k = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    return p[k] / (2 * np.pi * STRIDE_HZ)


@pytest.mark.parametrize("rate_hz", [100.0, 200.0, 500.0])
def test_the_points_are_where_tables_2_and_3_put_them(rate_hz):
    phases = gait_phases(thigh_rate(rate_hz), rate_hz)
    stride_s = 1 / STRIDE_HZ
    # of the analytic signal, in one stride from swing (p = 0) to swing (p = 2 pi)
    rate = lambda p: 1.8 * np.cos(p) + 1.1 * np.cos(2 * p) + 0.6 * np.cos(3 * p)  # noqa: E731
    slope = lambda p: -1.8 * np.sin(p) - 2.2 * np.sin(2 * p) - 1.8 * np.sin(3 * p)  # noqa: E731
    zeros = true_zeros(rate, 0.01, 2 * np.pi - 0.01)
    turns = true_zeros(slope, 0.01, 2 * np.pi - 0.01)
    expected = {"a": zeros[0], "e": zeros[-1], "b": turns[0], "f": stride_s}
    for point, place in expected.items():
        within = np.mod(phases.times_s[point] - place + stride_s / 2, stride_s) - stride_s / 2
        # the low-pass filter at 6 Hz moves sharp turns a little
        assert np.nanmax(np.abs(within)) < 0.012, point


def test_points_come_in_order_and_g_is_the_next_b():
    phases = gait_phases(thigh_rate(noise=0.05), 100.0)
    assert phases.n_strides >= N_STRIDES - 3
    ordered = np.column_stack([phases.times_s[point] for point in MEANING])
    complete = np.isfinite(ordered).all(axis=1)
    assert complete.sum() >= phases.n_strides - 2
    assert (np.diff(ordered[complete], axis=1) > 0).all()
    np.testing.assert_array_equal(phases.times_s["g"][:-1], phases.times_s["b"][1:])
    assert {point for pair in PHASES.values() for point in pair} == set("bcdefg")


def test_statistics():
    statistics = gait_phases(thigh_rate(noise=0.02), 100.0).statistics()
    assert statistics["stride_time_s"] == pytest.approx(1 / STRIDE_HZ, rel=0.002)
    assert statistics["cadence_steps_per_min"] == pytest.approx(120 * STRIDE_HZ, rel=0.002)
    assert statistics["stride_time_cv_percent"] < 1.0
    assert statistics["n_strides"] >= N_STRIDES - 4


def test_a_gap_loses_its_strides_and_no_more():
    rate = thigh_rate()
    rate[1000:1010] = np.nan
    phases = gait_phases(rate, 100.0)
    everything = np.concatenate(list(phases.times_s.values()))
    assert not ((everything > 9.99) & (everything < 10.1)).any()
    assert phases.n_strides >= N_STRIDES - 6
    # the interval across the gap is not a stride
    assert np.nanmax(phases.stride_times_s()) < 1.1 / STRIDE_HZ


def test_the_table():
    phases = gait_phases(thigh_rate(), 100.0)
    table = phases.frame()
    assert list(table.columns) == ["stride", "point", "meaning", "time_s"]
    assert len(table) == 7 * phases.n_strides
    first = table[table.stride == 0]
    assert first.point.tolist() == list("abcdefg")
    assert first.time_s.is_monotonic_increasing


def test_the_derivative_is_one():
    t = np.arange(1000) / 100.0
    smooth, derivative = smooth_rate_and_derivative(np.sin(2 * np.pi * t), 100.0)
    inside = slice(200, -200)
    np.testing.assert_allclose(smooth[inside], np.sin(2 * np.pi * t)[inside], atol=2e-3)
    np.testing.assert_allclose(
        derivative[inside], 2 * np.pi * np.cos(2 * np.pi * t)[inside], atol=0.02
    )


def test_no_walking_is_refused():
    with pytest.raises(UserError, match="no walking found"):
        gait_phases(np.zeros(1000), 100.0)


@pytest.fixture(scope="module")
def walks():
    """Simulated treadmill walks: the trial, the calibrated thigh's rate, its phases."""
    source = SimulatedGait(
        subjects=["S1", "S4"],
        conditions=["slow", "fast"],
        treadmill_duration_s=40.0,
        sampling_rate_hz=100.0,
        segments=["thigh_right"],
    )
    return [
        (trial, calibrate(trial)["thigh_right"].signals.axis_rates_rad_s[:, 0]) for trial in source
    ]


def differences_s(times, events):
    """Difference from each event to the nearest detected time, within 0.4 s."""
    found = times[np.isfinite(times)]
    assert found.size
    nearest = np.array([found[np.argmin(np.abs(found - event))] - event for event in events])
    return nearest[np.abs(nearest) < 0.4]


# by the simulator's own events a thigh's dip comes within 0.1 s of its heel strike, its highest
# rate up to 0.12 s after its toe-off, its turn forward up to 0.15 s after the other heel strike
@pytest.mark.parametrize(
    ("point", "event", "earliest_s", "latest_s"),
    [
        ("b", "heel_strike_right", -0.12, 0.06),
        ("f", "toe_off_right", -0.02, 0.15),
        ("e", "heel_strike_left", -0.03, 0.18),
    ],
)
def test_events_of_the_simulator(walks, point, event, earliest_s, latest_s):
    seen = 0
    for trial, rate in walks:
        times = gait_phases(rate, trial.sampling_rate_hz).times_s[point]
        if point == "b" and np.isfinite(times).mean() < 0.5:
            continue  # not every thigh's rate dips at heel strike
        seen += 1
        events = trial.events[event] - trial.time_s[0]
        differences = differences_s(times, events[2:-2])
        assert len(differences) >= 0.8 * (len(events) - 4)
        median = np.median(differences)
        assert earliest_s < median < latest_s
        # always by about the same time, so that it marks the stride as well as the event would;
        # but a dip that is too shallow in some strides (S4, fast) is taken for that of mid stance
        usual = np.abs(differences - median) < 0.05
        assert usual.mean() > (0.65 if point == "b" else 0.99)
        assert differences[usual].std() < 0.02
    assert seen >= 2


def test_mid_stance_ends_at_about_a_third_of_the_stride(walks):
    for trial, rate in walks:
        heel_strikes = trial.events["heel_strike_right"] - trial.time_s[0]
        stride_s = np.median(np.diff(heel_strikes))
        d = gait_phases(rate, trial.sampling_rate_hz).times_s["d"]
        since = [t - heel_strikes[heel_strikes < t][-1] for t in d if t > heel_strikes[0]]
        assert 0.2 < np.median(since) / stride_s < 0.45


def test_stride_times_of_the_simulator(walks):
    for trial, rate in walks:
        heel_strikes = trial.events["heel_strike_right"][2:-2]
        true = np.diff(heel_strikes)
        statistics = gait_phases(rate, trial.sampling_rate_hz).statistics()
        assert statistics["stride_time_s"] == pytest.approx(np.mean(true), rel=0.01)
        assert stride_frequency_hz(rate, trial.sampling_rate_hz) == pytest.approx(
            1 / np.mean(true), rel=0.02
        )


def phases_at(times_s):
    times = np.asarray(times_s, dtype=float)
    return GaitPhases({point: times + 0.1 * k for k, point in enumerate(MEANING)})


def test_a_pause_is_no_stride_and_a_slow_stride_is_one():
    """An interval of up to 1.75 usual strides is a stride; one of 2 is a pause or a lost stride."""
    found = phases_at([0.0, 1.0, 2.0, 3.7, 4.7, 6.5, 7.5]).stride_times_s("e")
    np.testing.assert_allclose(found, [1.0, 1.0, 1.7, 1.0, np.nan, 1.0])


def test_statistics_by_hand():
    found = phases_at([0.0, 1.0, 2.1, 3.0]).statistics("a")
    spread = np.std([1.0, 1.1, 0.9], ddof=1)
    assert found == pytest.approx(
        {
            "n_strides": 3.0,
            "stride_time_s": 1.0,
            "stride_time_sd_s": spread,
            "stride_time_cv_percent": 100 * spread,
            "cadence_steps_per_min": 120.0,
        }
    )
    assert np.isnan(phases_at([0.0]).statistics()["stride_time_s"])


def test_a_pause_between_two_walks_is_no_stride():
    walk = thigh_rate()
    # four seconds from swing to swing
    stopped = np.concatenate([walk, np.zeros(300), walk])
    phases = gait_phases(stopped, 100.0)
    ends_s = len(walk) / 100.0
    pause = (phases.times_s["a"] < ends_s) & (phases.times_s["e"] > ends_s + 3.0)
    assert not pause.any()
    last = np.flatnonzero(phases.times_s["a"] < ends_s)[-1]
    assert np.isnan(phases.times_s["g"][last])


def test_pieces_keep_their_time_and_crossings_lie_between_samples():
    rate = thigh_rate(50.0)
    whole = gait_phases(rate, 50.0).times_s["e"]
    rate[:5] = np.nan
    later = gait_phases(rate, 50.0).times_s["e"]
    shared = min(len(whole), len(later))
    np.testing.assert_allclose(whole[-shared:], later[-shared:], atol=2e-3)
    # equal strides: without interpolation they would differ by a sample, 20 ms
    assert np.std(np.diff(whole[2:-2])) < 1.5e-3


@pytest.mark.parametrize("depths", [(0.4, 0.9), (0.9, 0.4)])
def test_mid_stance_ends_at_the_deeper_of_two_dips(depths):
    """One swing per stride of 1.1 s, with dips 0.5 and 0.75 s after it."""
    time_s = np.arange(0.0, 22.0, 0.01)
    since_s = (time_s + 0.3) % 1.1 - 0.3
    rate = 3.0 * np.exp(-((since_s / 0.13) ** 2)) - 0.5
    for at_s, depth in zip((0.5, 0.75), depths, strict=True):
        rate -= depth * np.exp(-(((since_s - at_s) / 0.07) ** 2))
    d = gait_phases(rate, 100.0).times_s["d"]
    deeper_s = (0.5, 0.75)[int(np.argmax(depths))]
    np.testing.assert_allclose(d[2:-2] % 1.1, deeper_s, atol=0.03)


@pytest.mark.parametrize("frequency_hz", [3.0, 4.0, 6.0, 9.0])
def test_the_low_pass_is_of_second_order_forwards_and_backwards(frequency_hz):
    """Once each way: the power that a Butterworth filter passes, 1 / (1 + (f / 6 Hz)^4)."""
    wave = np.sin(2 * np.pi * frequency_hz * np.arange(4000) / 1000.0)
    smooth, _ = smooth_rate_and_derivative(wave, 1000.0)
    gain = 1.0 / (1.0 + (frequency_hz / 6.0) ** 4)
    np.testing.assert_allclose(smooth[1000:-1000], gain * wave[1000:-1000], atol=2e-3)


@pytest.mark.parametrize(("strides", "found"), [(1.9, False), (2.9, True)])
def test_a_piece_of_two_strides_is_the_shortest(strides, found):
    """A gap on either side of it; all else is a walk."""
    rate = thigh_rate()
    begin_s, end_s = 10.0, 10.0 + strides / STRIDE_HZ
    begin, end = round(100 * begin_s), round(100 * end_s)
    rate[begin - 5 : begin] = rate[end : end + 5] = np.nan
    times = np.concatenate(list(gait_phases(rate, 100.0).times_s.values()))
    assert ((times > begin_s) & (times < end_s)).any() == found


def test_the_usual_stride_is_the_median():
    """Two pauses of 8 s among four strides of 1 s would make a mean of 3.3 s."""
    found = phases_at([0.0, 1.0, 9.0, 10.0, 11.0, 19.0, 20.0, 22.0]).stride_times_s("e")
    np.testing.assert_allclose(found, [1.0, np.nan, 1.0, 1.0, np.nan, 1.0, np.nan])


def bumps(stride_s, *of_a_stride):
    """Twenty strides of a rate of -0.5 rad/s with bumps: place and width in s, height in rad/s."""
    time_s = np.arange(0.0, 20 * stride_s, 0.01)
    since_s = (time_s + 0.4) % stride_s - 0.4
    rate = np.full_like(time_s, -0.5)
    for at_s, width_s, height in of_a_stride:
        rate += height * np.exp(-(((since_s - at_s) / width_s) ** 2))
    return rate


def test_contact_is_the_first_dip_and_the_response_ends_at_the_steepest_rise():
    """Two dips after the swing, of which the second is deeper, and that of mid stance."""
    rate = bumps(1.6, (0.0, 0.15, 3.0), (0.30, 0.06, -0.6), (0.50, 0.06, -0.9), (1.1, 0.1, -0.9))
    times = {point: t[2:-2] % 1.6 for point, t in gait_phases(rate, 100.0).times_s.items()}
    np.testing.assert_allclose(times["a"], 0.15 * np.sqrt(np.log(6.0)), atol=0.03)
    np.testing.assert_allclose(times["b"], 0.30, atol=0.03)
    np.testing.assert_allclose(times["c"], 0.50 + 0.06 / np.sqrt(2.0), atol=0.03)
    np.testing.assert_allclose(times["d"], 1.1, atol=0.03)


def test_a_swing_with_two_peaks_ends_after_the_second():
    """The first is higher, but brief, and the rate falls through zero between them as well."""
    rate = bumps(1.1, (-0.16, 0.05, 4.0), (0.16, 0.1, 2.8))
    a = gait_phases(rate, 100.0).times_s["a"][2:-2]
    np.testing.assert_allclose(np.diff(a), 1.1, atol=0.01)
    np.testing.assert_allclose(a % 1.1, 0.16 + 0.1 * np.sqrt(np.log(5.6)), atol=0.03)
