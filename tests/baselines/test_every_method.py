"""The contract of every method; a method is tested by being listed in `CASES`."""

import copy
import importlib.util
import pickle
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
import torch

from narx import baselines
from narx.errors import MethodNotApplicableError
from narx.inference.narx_method import NarxMethod
from narx.inference.start_up import StartUp
from narx.inference.stream import OrientationStream
from narx.method import OrientationMethod, SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.recordings.trial import GRAVITY_M_S2
from narx.training.initial_weights import leaky_integrator_weights

METHODS = {getattr(baselines, name).name: getattr(baselines, name) for name in baselines.__all__}

RATES_HZ = (100.0, 200.0, 500.0)


@dataclass(frozen=True)
class Case:
    """A method with its parameters, and what it promises.

    Tolerances are in degrees. `rate_tolerance` is the largest difference between the same
    motion at 100, 200 and 500 Hz. `turn_tolerance` is the largest error of the tilt after the
    walker has turned by 180 degrees, `None` where the method makes no promise (it integrates
    each axis on its own and forgets nothing). `bias_error` is the largest angle that a constant
    bias of 0.5 deg/s may have become after two minutes at rest.
    """

    name: str
    parameters: dict[str, Any] = field(default_factory=dict)
    motion: str = "walking"
    turn_motion: str = "half_turn"
    rate_tolerance: float = 0.1
    bias_error: float = 2.0
    turn_tolerance: float | None = 10.0
    tilt_at_rest: bool = True
    make: Callable[..., OrientationMethod] | None = None  # for a method outside the registry

    def method(self):
        if self.make is not None:
            return self.make(**self.parameters)
        return METHODS[self.name](**self.parameters)

    def __str__(self):
        return "-".join([self.name, *(f"{k}={v}" for k, v in self.parameters.items())])


def narx(network_rate_hz=100.0, coupled=True, start_up_s=6.0):
    """The network that training starts from; at other rates it goes through the conversion."""
    model = Narx(network_rate_hz, Normalisation(2.0, 0.25), coupled=coupled)
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(leaky_integrator_weights(model)))
    return NarxMethod(model, StartUp(duration_s=start_up_s, averaging_s=max(start_up_s / 2, 1.0)))


START_UP = {"duration_s": 6.0, "averaging_s": 3.0}
DRIFTS = 60.0 + 0.1  # 120 s of 0.5 deg/s

CASES = [
    Case("gyro_integration", bias_error=DRIFTS, turn_tolerance=None, tilt_at_rest=False),
    Case(
        "gyro_integration",
        {"rule": "rectangle"},
        rate_tolerance=1.5,  # half a sample of 170 deg/s
        bias_error=DRIFTS,
        turn_tolerance=None,
        tilt_at_rest=False,
    ),
    Case("gyro_integration", {"coupled": True}, bias_error=2 * DRIFTS, tilt_at_rest=False),
    Case("strapdown", bias_error=2 * DRIFTS, tilt_at_rest=False),
    Case("zero", tilt_at_rest=False, turn_tolerance=30.0),
    Case("constant", tilt_at_rest=False, turn_tolerance=30.0),
    Case("leaky_integrator", bias_error=2.6, tilt_at_rest=False, turn_tolerance=None),
    *(
        Case(
            name,
            {"coupled": True, "start_up": START_UP, "washout_s": 300.0, "smoothing": smoothing},
            bias_error=2 * DRIFTS,
            tilt_at_rest=False,
            turn_tolerance=15.0,
        )
        for name in ("leaky_integrator", "pseudo_integrator", "complementary_filter")
        for smoothing in (False, True)
    ),
    Case(
        "pseudo_integrator",
        {"frequency": "following", "coupled": True, "start_up": START_UP, "washout_s": 300.0},
        bias_error=2 * DRIFTS,
        tilt_at_rest=False,
        turn_tolerance=15.0,
    ),
    Case(
        "giof",
        {"mode": "real_time", "coupled": True, "start_up": START_UP, "washout_s": 300.0},
        bias_error=2 * DRIFTS,
        rate_tolerance=0.3,
        tilt_at_rest=False,
        turn_tolerance=15.0,
    ),
    Case(
        "giof",
        {"coupled": True, "start_up": START_UP, "smoothing": True},
        bias_error=2 * DRIFTS,
        rate_tolerance=0.2,
        tilt_at_rest=False,
        turn_tolerance=15.0,
    ),
    Case("pseudo_integrator", bias_error=1e-3, tilt_at_rest=False, turn_tolerance=15.0),
    Case(
        "pseudo_integrator",
        {"frequency": "following"},
        bias_error=1e-3,
        tilt_at_rest=False,
        turn_tolerance=15.0,
    ),
    Case(
        "pseudo_integrator",
        {"gait_frequency_hz": 0.9},
        bias_error=1e-3,
        tilt_at_rest=False,
        turn_tolerance=15.0,
    ),
    Case("complementary_filter", turn_tolerance=15.0),
    Case("complementary_filter", {"rule": "rectangle"}, rate_tolerance=1.5, turn_tolerance=15.0),
    Case("giof", bias_error=0.1),
    Case("giof", {"axes": ["sagittal"]}, bias_error=0.1),
    Case("giof", {"offset_window_s": None}, bias_error=0.1),
    # causal, each axis integrated separately; nothing bounds the frontal drift in a walk
    Case("giof", {"mode": "real_time"}, bias_error=0.1, rate_tolerance=0.2, turn_tolerance=None),
    # one sample is enough here: at the end of a swing the rate is below the threshold for 15 ms,
    # which 100 Hz now and then misses
    Case("giof", {"rest_s": 0.0}, bias_error=0.1, rate_tolerance=8.0),
    Case(
        "giof",
        {"mode": "real_time", "rest_s": 0.0, "axes": ["sagittal"]},
        bias_error=0.1,
        rate_tolerance=8.0,
    ),
    Case(
        "two_point",
        motion="stand_walk_stand",
        turn_motion="stand_turn_stand",
        rate_tolerance=0.5,  # at A and B, where the angle source changes
        bias_error=0.1,
        turn_tolerance=10.0,
    ),
    # the libraries use the rectangle rule: half a sample of 140 deg/s
    Case("vqf", rate_tolerance=0.8),
    Case("vqf", {"offline": True}, rate_tolerance=0.8),
    Case("vqf", {"heading": "leak", "start_up": START_UP}, rate_tolerance=0.8),
    Case("vqf", {"heading": "zero"}, rate_tolerance=0.8),
    Case("madgwick", rate_tolerance=1.5),
    Case("mahony", rate_tolerance=0.8),
    # a known start is integrated until movement begins, so at rest the bias is integrated too
    *(
        Case(
            "narx",
            parameters,
            rate_tolerance=0.05,
            bias_error=2 * DRIFTS,
            tilt_at_rest=False,
            turn_tolerance=tolerance,
            make=narx,
        )
        for parameters, tolerance in (
            ({}, 5.0),
            ({"network_rate_hz": 50.0}, 5.0),
            ({"network_rate_hz": 500.0}, 5.0),
            ({"coupled": False}, None),
        )
    ),
    Case(
        "narx",
        {"start_up_s": 0.0},
        rate_tolerance=0.05,
        bias_error=4.0,
        tilt_at_rest=False,
        turn_tolerance=5.0,
        make=narx,
    ),
]

LIBRARIES = {"vqf": "vqf"}


@pytest.fixture(params=CASES, ids=str)
def case(request):
    library = LIBRARIES.get(request.param.name)
    if library is not None and importlib.util.find_spec(library) is None:
        pytest.skip(f"{library} is not installed")
    return request.param


def at_rest(n, rate_hz=100.0, angles=None):
    force = np.tile([0.0, 0.0, GRAVITY_M_S2], (n, 1))
    return SegmentSignals("thigh_right", rate_hz, np.zeros((n, 3)), force, angles)


def observed(angles):
    """Columns that the method observes at all."""
    return np.flatnonzero(np.isfinite(angles).any(axis=0))


def test_every_registered_method_is_tested():
    assert {case.name for case in CASES} >= set(METHODS)


def test_its_name_is_its_key(case):
    assert case.method().name == case.name


def test_the_sampling_rate_does_not_matter(case, motion):
    walks = [motion(case.motion, rate_hz, 20.0) for rate_hz in RATES_HZ]
    estimates = [
        np.rad2deg(case.method().estimate(walk.signals))[:: int(rate_hz / RATES_HZ[0])]
        for walk, rate_hz in zip(walks, RATES_HZ, strict=True)
    ]
    finest = estimates[-1]
    columns = observed(finest)
    for estimate in estimates[:-1]:
        difference = np.abs(estimate - finest)[:, columns]
        assert difference.max() < case.rate_tolerance


def test_nothing_in_nothing_out(case):
    angles = case.method().estimate(at_rest(500, angles=np.zeros(3)))
    assert angles.shape == (500, 3)
    columns = observed(angles)
    assert 0 in columns
    np.testing.assert_allclose(angles[:, columns], 0.0, atol=1e-12)


def test_an_accelerometer_at_rest_gives_the_tilt(case, motion):
    if not case.tilt_at_rest:
        pytest.skip("does not look at the accelerometer")
    tilted = motion("tilted", duration_s=5.0)
    angles = case.method().estimate(tilted.signals)
    columns = observed(angles)
    np.testing.assert_allclose(
        angles[-1, columns], tilted.angles_rad[-1, columns], atol=np.deg2rad(0.1)
    )


def test_a_constant_bias_has_a_bounded_effect(case):
    signals = at_rest(12001, angles=np.zeros(3))
    rates = np.full((12001, 3), np.deg2rad(0.5))
    angles = np.rad2deg(case.method().estimate(replace(signals, axis_rates_rad_s=rates)))
    tilt = angles[-1, [column for column in observed(angles) if column < 2]]
    assert np.abs(tilt).max() < case.bias_error


def test_the_tilt_survives_a_half_turn(case, motion):
    if case.turn_tolerance is None:
        pytest.skip("makes no promise: it integrates each axis on its own and forgets nothing")
    turn = motion(case.turn_motion, duration_s=40.0)
    angles = case.method().estimate(turn.signals)
    columns = [column for column in observed(angles) if column < 2]
    after = turn.time_s > 30.0
    error = np.rad2deg(angles - turn.angles_rad)[after][:, columns]
    assert np.abs(error).max() < case.turn_tolerance


def test_it_does_not_change_its_input(case, motion):
    walk = motion(case.motion, duration_s=15.0)
    rates = walk.signals.axis_rates_rad_s.copy()
    force = walk.signals.specific_force_m_s2.copy()
    case.method().estimate(walk.signals)
    np.testing.assert_array_equal(walk.signals.axis_rates_rad_s, rates)
    np.testing.assert_array_equal(walk.signals.specific_force_m_s2, force)


def test_the_same_twice(case, motion):
    walk = motion(case.motion, duration_s=15.0)
    method = case.method()
    np.testing.assert_array_equal(method.estimate(walk.signals), method.estimate(walk.signals))


@pytest.mark.parametrize("n", [0, 1, 2, 3])
def test_very_short_recordings(case, n):
    try:
        angles = case.method().estimate(at_rest(n))
    except MethodNotApplicableError:
        return  # refusing with a message is allowed
    assert angles.shape == (n, 3)
    assert not np.isinf(angles).any()


def with_gap(walk, begin, end):
    rates = walk.signals.axis_rates_rad_s.copy()
    force = walk.signals.specific_force_m_s2.copy()
    rates[begin:end] = np.nan
    force[begin:end] = np.nan
    return replace(walk.signals, axis_rates_rad_s=rates, specific_force_m_s2=force)


def test_a_gap_stays_a_gap_and_nothing_else_is_lost(case, motion):
    walk = motion(case.motion, duration_s=20.0)
    gap = np.zeros(walk.signals.n_samples, dtype=bool)
    gap[1000:1003] = True
    angles = case.method().estimate(with_gap(walk, 1000, 1003))
    columns = observed(angles)
    assert np.isnan(angles[gap]).all()
    assert np.isfinite(angles[~gap][:, columns]).all()
    whole = case.method().estimate(walk.signals)
    # three samples of the walk are at most 5 degrees
    after = walk.time_s > 12.0
    assert np.rad2deg(np.abs(angles - whole)[after][:, columns].max()) < 6.0


def test_all_missing_is_all_missing(case):
    signals = at_rest(50)
    signals = replace(
        signals,
        axis_rates_rad_s=np.full((50, 3), np.nan),
        specific_force_m_s2=np.full((50, 3), np.nan),
    )
    assert np.isnan(case.method().estimate(signals)).all()


def test_sample_by_sample_is_the_same_as_at_once(case, motion):
    method = case.method()
    walk = motion(case.motion, duration_s=12.0)
    for start in (None, np.array([0.2, -0.1, 0.3])):
        signals = replace(with_gap(walk, 600, 603), initial_angles_rad=start)
        try:
            stream = OrientationStream(method, 100.0, initial_angles_rad=start)
        except MethodNotApplicableError:
            pytest.skip("needs the whole recording")
        samples = np.hstack([signals.axis_rates_rad_s, signals.specific_force_m_s2])
        whole = method.estimate(signals)
        for k, sample in enumerate(samples):
            if k == 500:
                stream = pickle.loads(pickle.dumps(copy.deepcopy(stream)))
            angles = stream.update(sample).angles_rad
            np.testing.assert_allclose(angles, whole[k], rtol=0, atol=1e-9)
