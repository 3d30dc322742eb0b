"""A tracker around the leaky integrator and the integrated gyroscope."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from narx.baselines.gyro_integration import GyroIntegration
from narx.baselines.leaky_integrator import LeakyIntegrator
from narx.errors import MethodNotApplicableError, UserError
from narx.inference.checkpoint import Checkpoint
from narx.inference.tracker import PostureTracker, leak_rad_s
from narx.kinematics.segment_angles import axis_rates, orientation_from_angles
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.initial_weights import leaky_integrator_weights

RATE_HZ = 50.0


@pytest.fixture(scope="module")
def truth():
    """A walk of a minute about a tilted posture, rad."""
    phase = 2.0 * np.pi * 0.9 * np.arange(0.0, 60.0, 1.0 / RATE_HZ)
    swing = np.sin(phase) + 0.3 * np.sin(2.0 * phase)
    return np.radians(np.column_stack([20.0 * swing, 4.0 * np.cos(phase), 3.0 * np.sin(phase)]))


@pytest.fixture(scope="module")
def signals(truth):
    turned = Rotation.from_quat(orientation_from_angles(truth), scalar_first=True)
    rates = (turned[:-1].inv() * turned[1:]).as_rotvec() * RATE_HZ
    rates = 0.5 * (np.vstack([rates[:1], rates]) + np.vstack([rates, rates[-1:]]))
    force = turned.inv().apply(np.tile([0.0, 0.0, 9.81], (len(rates), 1)))
    # a bias that was left in
    biased = axis_rates(rates) + np.radians([1.0, -0.8, 0.0])
    return SegmentSignals("thigh", RATE_HZ, biased, force)


def off_deg(method, signals, truth):
    error = np.degrees(truth - method.estimate(signals))[1000:, :2]
    return np.sqrt(np.mean(error**2, axis=0)).max()


@pytest.mark.parametrize("parameters", [{}, {"aided": True}], ids=["gyroscope", "aided"])
def test_it_is_the_networks_tracker_around_another_recursion(signals, parameters):
    model = Narx(RATE_HZ, Normalisation(2.0, 0.25))
    with torch.no_grad():
        # so small an argument that tanh is linear to nine digits
        model.weights.copy_(torch.from_numpy(leaky_integrator_weights(model, 0.2, slope=1e-5)))
    network = Checkpoint(model, tracker=PostureTracker(**parameters)).method()
    method = LeakyIntegrator(0.2, coupled=True, tracker=parameters or True)
    np.testing.assert_allclose(method.estimate(signals), network.estimate(signals), atol=1e-6)
    assert method.needs_accelerometer == bool(parameters)


def test_it_finds_a_bias_that_a_start_up_leaves_in(signals, truth):
    doubtful = {"bias_sd_deg_s": 2.0}
    tracked = off_deg(LeakyIntegrator(0.2, coupled=True, tracker=doubtful), signals, truth)
    started = off_deg(LeakyIntegrator(0.2, coupled=True, start_up=True), signals, truth)
    assert tracked < 2.0
    assert started > 2.0 * tracked
    # integration needs no leak beside it
    assert off_deg(GyroIntegration(coupled=True, tracker=doubtful), signals, truth) < 2.0


@pytest.mark.parametrize(
    ("method", "leak"),
    [
        (LeakyIntegrator(0.3, coupled=True, tracker=True), 0.3),
        (GyroIntegration(coupled=True, tracker=True), 0.0),
        (GyroIntegration("rectangle", coupled=True, tracker=True), 0.0),
    ],
)
def test_samples_one_by_one_and_missing_ones(signals, method, leak):
    linear = method._linear(RATE_HZ)
    assert leak_rad_s(linear) == pytest.approx(leak)
    # newest first: a rectangle is of the present rate
    present = 0.02 if getattr(method, "rule", "") == "rectangle" else 0.01 / (1.0 + 0.02 * leak)
    assert linear.inputs[0] == pytest.approx(present)
    rates = signals.axis_rates_rad_s.copy()
    rates[500:530] = np.nan
    gappy = SegmentSignals("thigh", RATE_HZ, rates, signals.specific_force_m_s2)
    whole = method.estimate(gappy)
    assert np.isnan(whole[500:530]).all()
    recursion = method.recursion(RATE_HZ, 1, None)
    parts = [
        recursion.advance(part, np.array([0, len(part)]))[0] for part in np.array_split(rates, 40)
    ]
    np.testing.assert_array_equal(np.concatenate(parts), whole)


def test_it_begins_at_a_known_start(signals):
    start = np.array([0.4, -0.1, 0.3])
    known = replace(signals, initial_angles_rad=start)
    method = LeakyIntegrator(0.2, coupled=True, tracker=True)
    whole = method.estimate(known)
    np.testing.assert_allclose(whole[0], start, atol=0.04)
    recursion = method.recursion(RATE_HZ, 1, start[None])
    samples = known.axis_rates_rad_s[:100]
    found, *_ = recursion.advance(samples, np.array([0, len(samples)]))
    np.testing.assert_array_equal(found, whole[:100])


def test_both_directions_need_the_whole_recording(signals, truth):
    once = LeakyIntegrator(0.2, coupled=True, tracker=True)
    twice = LeakyIntegrator(0.2, coupled=True, tracker=True, smoothing=True)
    assert not twice.causal
    assert off_deg(twice, signals, truth) < off_deg(once, signals, truth)
    with pytest.raises(MethodNotApplicableError, match="smoothing needs the whole recording"):
        twice.recursion(RATE_HZ, 1, None)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"tracker": True}, "leaky_integrator: a tracker needs coupled=true"),
        ({"coupled": True, "tracker": 3}, "tracker is 3, expected true, null, or its parameters"),
        ({"coupled": True, "tracker": {"lean": 3}}, "tracker has no parameter 'lean', expected"),
        ({"coupled": True, "tracker": {"idle_s": -1}}, "tracker.idle_s is -1, expected a number"),
    ],
)
def test_nonsense_is_refused(parameters, message):
    with pytest.raises(UserError, match=message):
        LeakyIntegrator(**parameters)
