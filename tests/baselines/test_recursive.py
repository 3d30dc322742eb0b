"""The ingredients act on every recursive method as they do on the network."""

import inspect
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from narx import baselines
from narx.baselines.recursive import RecursiveMethod
from narx.errors import MethodNotApplicableError, UserError
from narx.inference.stream import OrientationStream
from narx.kinematics.segment_angles import coupled_rates
from narx.method import SegmentSignals

METHODS = {getattr(baselines, name).name: getattr(baselines, name) for name in baselines.__all__}
RECURSIVE = sorted(name for name, made in METHODS.items() if issubclass(made, RecursiveMethod))


def written_by_hand(rates, interval, leak, initial, washout):
    """One-parameter coupled leaky integrator with start-up and washout, from nothing but numpy."""
    angle, before, mean = np.array(initial), np.zeros(3), np.zeros(3)
    posture, weight, moving, square = np.zeros(3), 0.0, 0.0, 0.0
    angles, over = [], False
    for rate in rates:
        if not over and moving >= 12.0:  # the start-up's movement, s
            over, posture = True, posture / weight
        turned = coupled_rates(rate, angle + interval * before)
        square += (np.sum(rate**2) - square) * interval / (1.0 + interval)
        moving += interval * (square > 0.35**2)
        angle = angle + 0.5 * interval * (turned + before)
        before = turned
        if not over:
            hann = np.sin(np.pi * (moving - 2.0) / 6.0) ** 2 if 2.0 < moving < 8.0 else 0.0
            posture, weight = posture + hann * angle, weight + hann
            angles.append(angle)
            continue
        angle = posture + (angle - posture) / (1.0 + interval * leak)
        mean = mean + interval / (washout + interval) * (angle - posture - mean)
        angles.append(angle - mean)
    return np.array(angles)


@pytest.mark.parametrize("initial", [(0.0, 0.0, 0.0), (0.3, -0.1, 0.2)])
def test_the_leaky_integrator_is_the_one_written_by_hand(motion, initial):
    start = np.array(initial)
    walk = motion("half_turn", duration_s=60.0).changed(initial_angles_rad=start).signals
    method = METHODS["leaky_integrator"](0.23, coupled=True, start_up=True, washout_s=300.0)
    expected = written_by_hand(walk.axis_rates_rad_s, 0.01, 0.23, start, 300.0)
    np.testing.assert_allclose(method.estimate(walk), expected, rtol=0, atol=1e-9)


def test_without_ingredients_it_is_one_line_of_scipy(motion):
    walk = motion("walking", duration_s=20.0).signals
    rates = walk.axis_rates_rad_s
    kept = 1.0 / (1.0 + 0.01 * 0.4)
    steps = np.diff(np.cumsum(rates, axis=0), axis=0, prepend=np.zeros((1, 3)))
    steps = 0.005 * (steps + np.vstack([-steps[:1], steps[:-1]]))
    expected = lfilter([kept], [1.0, -kept], steps, axis=0)
    angles = METHODS["leaky_integrator"](0.4).estimate(walk)
    np.testing.assert_allclose(angles, expected, atol=1e-12)


@pytest.mark.parametrize("name", RECURSIVE)
def test_coupled_axes_book_no_turn_as_flexion(motion, name):
    """A coupled method responds to a turning leg as to the true rates of the angles."""
    turn = motion("half_turn", duration_s=60.0)
    true_rates = np.gradient(turn.angles_rad, 0.01, axis=0)
    expected = METHODS[name]().estimate(turn.changed(axis_rates_rad_s=true_rates).signals)
    coupled, plain = (
        np.abs(METHODS[name](coupled=coupled).estimate(turn.signals) - expected)[:, :2].max()
        for coupled in (True, False)
    )
    assert coupled < 0.5 * plain


@pytest.mark.parametrize("name", RECURSIVE)
def test_a_start_up_adds_the_mean_angle_of_a_known_start(motion, name):
    walk = motion("walking", duration_s=40.0)
    lean = np.array([0.3, 0.0, 0.0])
    signals = walk.changed(initial_angles_rad=lean).signals
    # a gyroscope sees no lean: the rates of the same walk leaned forward about the same axis
    method = METHODS[name](start_up=True, **({"axes": ["sagittal"]} if name in AXES else {}))
    first = method.estimate(signals)[:1200, 0]
    np.testing.assert_allclose(first, walk.angles_rad[:1200, 0] + 0.3, atol=0.02)


@pytest.mark.parametrize("name", RECURSIVE)
@pytest.mark.parametrize("coupled", [True, False])
def test_sample_by_sample_it_is_the_same(motion, name, coupled):
    """With a posture that the start-up finds, and with what the method looks for in the data."""
    lean = np.array([0.4, -0.2, 0.3])
    signals = motion("half_turn", duration_s=30.0).changed(initial_angles_rad=lean).signals
    own = {"giof": {"mode": "real_time"}, "pseudo_integrator": {"frequency": "following"}}
    start_up = {"duration_s": 6.0, "averaging_s": 4.0}
    method = METHODS[name](start_up=start_up, washout_s=20.0, coupled=coupled, **own.get(name, {}))
    stream = OrientationStream(method, 100.0, initial_angles_rad=lean)
    columns = [signals.axis_rates_rad_s]
    columns += [signals.specific_force_m_s2] if method.needs_accelerometer else []
    found = stream.update_block(np.hstack(columns)).angles_rad
    np.testing.assert_allclose(found, method.estimate(signals), atol=1e-9)


def test_a_start_up_of_no_duration_is_none_sample_by_sample_too(motion):
    signals = motion("walking", duration_s=5.0).signals
    method = METHODS["leaky_integrator"](0.5, start_up={"duration_s": 0.0})
    plain = METHODS["leaky_integrator"](0.5)
    start = np.array([0.2, 0.1, -0.1])
    found = [
        OrientationStream(one, 100.0, initial_angles_rad=start)
        .update_block(signals.axis_rates_rad_s)
        .angles_rad
        for one in (method, plain)
    ]
    np.testing.assert_array_equal(*found)


def test_axes_that_are_not_wanted_are_missing_in_the_start_up_too(motion):
    signals = motion("walking", duration_s=20.0).signals
    method = METHODS["complementary_filter"](axes=["frontal"], start_up=True)
    angles = method.estimate(signals)
    assert np.isnan(angles[:, [0, 2]]).all()
    assert np.isfinite(angles[:, 1]).all()


AXES = ("complementary_filter", "giof")


@pytest.mark.parametrize("name", AXES)
def test_after_a_start_up_the_accelerometer_gives_the_tilt_not_the_deviation_from_the_posture(
    motion, name
):
    """A known start 0.3 rad from the tilt that the accelerometer shows in the walk and at rest."""
    walk = motion("stand_walk_stand", duration_s=60.0)
    signals = walk.changed(initial_angles_rad=np.array([0.3, -0.2, 0.0])).signals
    start_up = {"duration_s": 6.0, "averaging_s": 4.0}
    angles = METHODS[name](start_up=start_up).estimate(signals)
    np.testing.assert_allclose(angles[500, :2] - walk.angles_rad[500, :2], [0.3, -0.2], atol=0.02)
    np.testing.assert_allclose(angles[-1, :2], walk.angles_rad[-1, :2], atol=0.02)


@pytest.mark.parametrize("name", sorted(set(RECURSIVE) - set(AXES)))
def test_a_washout_removes_a_constant_deviation(motion, name):
    walk = motion("walking", duration_s=120.0).signals
    plain = METHODS[name]().estimate(walk)
    gain = 0.01 / (5.0 + 0.01)
    expected = lfilter([1.0 - gain, gain - 1.0], [1.0, gain - 1.0], plain, axis=0)
    np.testing.assert_allclose(METHODS[name](washout_s=5.0).estimate(walk), expected, atol=1e-9)


def test_smoothing_has_no_lag(motion):
    walk = motion("walking", duration_s=120.0)

    def lag_s(smoothing):
        method = METHODS["leaky_integrator"](1.0, smoothing=smoothing)
        error = (walk.angles_rad - method.estimate(walk.signals))[3000:9000, 0]
        slope = np.gradient(walk.angles_rad[:, 0], 0.01)[3000:9000]
        return error @ slope / (slope @ slope)

    assert lag_s(False) < -0.02  # a leak causes a phase lead
    assert abs(lag_s(True)) < 0.001


def test_smoothing_keeps_a_known_start_whose_share_fades_over_twelve_seconds():
    """A leg at rest: the forward pass forgets the pose, and the backward one never knew it."""
    pose, rest = np.array([0.3, -0.2, 0.1]), np.zeros((6000, 3))
    still = SegmentSignals("thigh", 100.0, rest, rest, pose)
    one, both = (
        METHODS["leaky_integrator"](0.5, smoothing=smoothing).estimate(still)
        for smoothing in (False, True)
    )
    np.testing.assert_array_equal(both[0], pose)
    share = 1.0 - 0.5 * np.minimum(np.arange(6000) / 1200.0, 1.0)
    np.testing.assert_allclose(both, share[:, None] * one, atol=1e-9)


def test_a_filter_that_starts_at_zero_knows_no_start(motion):
    walk = motion("walking", duration_s=20.0).signals
    given, unknown = (
        METHODS["pseudo_integrator"](smoothing=True).estimate(
            replace(walk, initial_angles_rad=pose)
        )
        for pose in (np.array([0.3, -0.2, 0.1]), None)
    )
    np.testing.assert_array_equal(given, unknown)


@pytest.mark.parametrize("name", RECURSIVE)
def test_smoothing_does_not_stream(name):
    given = {"gait_frequency_hz": 1.0} if name == "pseudo_integrator" else {}
    assert not METHODS[name](smoothing=True, **given).causal
    with pytest.raises(MethodNotApplicableError, match="smoothing needs the whole recording"):
        METHODS[name](smoothing=True, **given).recursion(100.0, 1, None)


@pytest.mark.parametrize(
    ("ingredients", "message"),
    [
        ({"coupled": 1}, "coupled is 1, expected true or false"),
        ({"smoothing": "yes"}, "smoothing is 'yes', expected true or false"),
        ({"washout_s": -1.0}, "washout_s is -1.0"),
        ({"start_up": 3.0}, "start_up is 3.0, expected true, null, or its parameters"),
        ({"start_up": {"duration": 3.0}}, "start_up has no parameter 'duration'"),
    ],
)
def test_wrong_ingredients_are_one_clear_line(ingredients, message):
    with pytest.raises(UserError, match=message):
        METHODS["leaky_integrator"](**ingredients)


@pytest.mark.parametrize("name", AXES)
def test_coupled_axes_need_both(name):
    with pytest.raises(UserError, match="coupled=true needs axes"):
        METHODS[name](axes=["sagittal"], coupled=True)


@pytest.mark.parametrize("name", RECURSIVE)
def test_every_recursive_method_takes_all_ingredients(name):
    parameters = inspect.signature(METHODS[name]).parameters
    assert {"coupled", "start_up", "washout_s", "smoothing"} <= set(parameters)
