"""Forward and backward pass of a tracker: reversal of time, and the average of both."""

from pathlib import Path

import numpy as np
import pytest
import torch
import yaml

from narx.inference.tracker import LinearRecursion, PostureTracker, leak_rad_s
from narx.inference.tracking import Tracked, Tracking, follow
from narx.kernels import leg
from narx.kernels import tracker_layout as kernel
from narx.network.model import Narx
from narx.network.normalisation import Normalisation


class _Passes:
    """A tracking with a given output of each pass, which keeps what it is given."""

    def __init__(self, output, back=None):
        self._output, self._back = output, back

    def follow(self, rates, force):
        self.given = rates.copy(), force.copy()
        return self._output

    def time_reversed(self):
        self.behind = _Passes(self._back.reversed())
        return self.behind


def _output(angle_rad, std_rad, corrected_rad=0.1, n=4):
    full = np.full((n, 3), 1.0)
    return Tracked(
        angle_rad * full, std_rad * full, np.ones(n), corrected_rad * full, np.ones(n, dtype=bool)
    )


def test_two_estimates_are_averaged_with_the_least_variance():
    """Of uncorrelated errors of 1 and 2, the least variance has 4/5 of the first."""
    passes = _Passes(_output(0.0, 1.0), _output(1.0, 2.0))
    found = follow(passes, np.zeros((4, 3)), aided=False, smoothing=True)
    np.testing.assert_allclose(found.angles_rad, 1.0 / 5.0)


@pytest.mark.parametrize("corrected", [(0.1, 0.3), (0.3, 0.1)])
def test_of_two_passes_the_larger_corrections_count(corrected):
    passes = _Passes(*(_output(0.0, 1.0, corrected_rad) for corrected_rad in corrected))
    found = follow(passes, np.zeros((4, 3)), aided=False, smoothing=True)
    np.testing.assert_array_equal(found.corrected_rad, np.full((4, 3), 0.3))


def test_backwards_in_time_samples_come_in_reversed_order_and_forces_keep_their_sign():
    samples = np.random.default_rng(0).normal(size=(4, 6))
    rates, force = samples[:, :3], samples[:, 3:]
    passes = _Passes(_output(0.0, 1.0), _output(0.0, 1.0))
    follow(passes, samples, aided=True, smoothing=True)
    np.testing.assert_array_equal(passes.given, [rates, force])
    np.testing.assert_array_equal(passes.behind.given, [-rates[::-1], force[::-1]])


def test_a_reversed_output_is_reversed_throughout():
    rng = np.random.default_rng(0)
    output = Tracked(*rng.normal(size=(2, 5, 3)), rng.normal(size=5), rng.normal(size=(5, 3)),
                     np.array([True, True, False, False, False]))  # fmt: skip
    for one, back in zip(output, output.reversed(), strict=True):
        np.testing.assert_array_equal(back, [one[4 - k] for k in range(5)])


def test_the_better_pass_gives_the_standard_deviation_and_the_forward_one_its_growth():
    for stds in ((1.0, 2.0), (2.0, 1.0)):
        forward, back = (_output(0.0, std) for std in stds)
        forward.std_growth[:], back.std_growth[:] = 1.5, 3.0
        found = follow(_Passes(forward, back), np.zeros((4, 3)), aided=False, smoothing=True)
        np.testing.assert_array_equal(found.std_rad, 1.0)
        np.testing.assert_array_equal(found.std_growth, 1.5)


def test_backwards_in_time_rates_change_their_sign_and_angles_do_not():
    recursion = LinearRecursion(50.0, (0.01, 0.01), (0.99, 0.0))
    tracking = Tracking(PostureTracker(), recursion, np.zeros(3))
    rng = np.random.default_rng(0)
    tracking.x[:] = rng.normal(size=len(tracking.x))
    root = rng.normal(size=(len(tracking.x),) * 2)
    tracking.covariance = root @ root.T
    back = tracking.time_reversed()
    bias = kernel.BIAS
    np.testing.assert_array_equal(back.x[:bias], tracking.x[:bias])
    np.testing.assert_array_equal(back.x[bias:], -tracking.x[bias:])
    ahead, behind = tracking.covariance, back.covariance
    np.testing.assert_array_equal(behind[:bias, bias:], -ahead[:bias, bias:])
    np.testing.assert_array_equal(behind[bias:, bias:], ahead[bias:, bias:])


def test_backwards_the_speed_is_negative_and_angles_continue_at_the_present_rate():
    recursion = LinearRecursion(50.0, (0.01, 0.01, 0.0), (0.9, 0.1, 0.0))
    tracking = Tracking(PostureTracker(aided=True, speed_m_s=0.7), recursion, np.zeros(3))
    tracking.rates[:] = [[1.0, 9.0], [2.0, 9.0], [-3.0, 9.0]]
    tracking.past[:] = [[0.1, 9.0, 9.0], [0.2, 9.0, 9.0], [0.3, 9.0, 9.0]]
    back = tracking.time_reversed()
    assert back.parameters[kernel.SPEED] == -0.7
    assert tracking.parameters[kernel.SPEED] == 0.7
    np.testing.assert_array_equal(back.rates, -tracking.rates)
    # in 0.02 and 0.04 s, whose samples come before the present one if time runs backwards
    np.testing.assert_allclose(back.past, [[0.1, 0.12, 0.14], [0.2, 0.24, 0.28], [0.3, 0.24, 0.18]])
    assert back.scalars[kernel.KNOWN] == 1.0
    unknown = Tracking(PostureTracker(), recursion, None).time_reversed()
    assert unknown.scalars[kernel.KNOWN] == 0.0


def test_both_passes_say_where_the_network_ran():
    forward, back = _output(0.0, 1.0), _output(0.0, 2.0)
    forward.by_network[:] = [True, True, False, False]
    back.by_network[:] = [True, False, True, False]
    found = follow(_Passes(forward, back), np.zeros((4, 3)), aided=False, smoothing=True)
    assert found.by_network.tolist() == [True, True, True, False]
    np.testing.assert_array_equal(found.std_rad, 1.0)


@pytest.mark.parametrize("known", [True, False])
def test_a_tracking_begins_as_uncertain_as_given(known):
    pose = np.array([0.3, -0.2, 0.1]) if known else None
    tracker = PostureTracker(
        start_sd_deg=50.0, posture_sd_deg=2.0, bias_sd_deg_s=0.4,
        known_start_sd_deg=1.0, known_posture_sd_deg=14.0, known_bias_sd_deg_s=0.2,
        lean_deg_s=2.5, lean_sd_deg_s=1.5, idle_s=1.25, aided=True, speed_m_s=0.8,
    )  # fmt: skip
    tracking = Tracking(tracker, LinearRecursion(50.0, (0.01, 0.01), (0.99, 0.0)), pose)
    sds = np.sqrt(np.diag(tracking.covariance))
    expected = (1.0, 14.0, 0.2) if known else (50.0, 2.0, 0.4)
    np.testing.assert_allclose(np.degrees(sds[:10]), [*np.repeat(expected, 3), 1.5])
    np.testing.assert_array_equal(sds[10:], 1.0)
    assert np.count_nonzero(tracking.covariance) == 12
    np.testing.assert_allclose(tracking.x[:3], pose if known else 0.0)
    assert tracking.x[kernel.LEAN] == pytest.approx(np.radians(2.5))
    assert tracking.x[kernel.VELOCITY :].tolist() == [0.8, 0.0]
    # not at rest, not walking, amid a swing
    scalars = tracking.scalars
    assert (scalars[kernel.SCATTER], scalars[kernel.IDLE]) == (1.0, 1.25)
    assert scalars[kernel.SINCE] == kernel.LONGEST_SWING_S
    # skewness is the cube over the square to 3/2: that of a leg, or none
    skewness = scalars[kernel.CUBE] / scalars[kernel.SQUARE] ** 1.5
    assert skewness == pytest.approx(leg.LEG_SKEWNESS if known else 0.0)


@pytest.mark.parametrize("rate_hz", [50.0, 200.0])
def test_the_numbers_of_a_tracker_mean_the_same_at_every_rate(rate_hz):
    """Noises by the variance of a second, decays and gains by their time constants."""
    recursion = LinearRecursion(rate_hz, (0.5 / rate_hz, 0.5 / rate_hz), (1.0, 0.0))
    numbers = PostureTracker().numbers(recursion)
    dt = 1.0 / rate_hz

    def in_a_second(index):
        return numbers[index] * rate_hz

    assert numbers[kernel.INTERVAL] == dt
    assert in_a_second(kernel.ANGLE_NOISE) == pytest.approx(np.radians(0.15) ** 2)
    assert in_a_second(kernel.RATE_NOISE) == pytest.approx(0.002**2)
    assert in_a_second(kernel.BIAS_NOISE) == pytest.approx(np.radians(0.02) ** 2)
    assert in_a_second(kernel.VELOCITY_NOISE) == pytest.approx(0.1**2)
    # means over a second
    assert numbers[kernel.REST_VARIANCE] * dt == pytest.approx(np.radians(0.5) ** 2)
    velocity = numbers[kernel.VELOCITY_VARIANCE : kernel.VELOCITY_VARIANCE + 2]
    np.testing.assert_allclose(velocity * dt, [0.9**2, 0.25**2])
    for index, time_s in {kernel.CENTRE_DECAY: 50.0, kernel.SPAN_DECAY: 0.6,
                          kernel.CORRECTED_KEPT: 15.0}.items():  # fmt: skip
        assert numbers[index] ** (time_s * rate_hz) == pytest.approx(np.exp(-1.0))
    # backward Euler: gain / (1 - gain) = dt / T
    for index, time_s in {kernel.TURN_GAIN: 0.2, kernel.REST_GAIN: 0.5, kernel.LEG_GAIN: 8.0,
                          kernel.TURNING_GAIN: 1.0}.items():  # fmt: skip
        assert numbers[index] / (1.0 - numbers[index]) == pytest.approx(dt / time_s)
    assert numbers[kernel.SWING_DECAY] == pytest.approx(1.0 + dt / 0.2)
    # what is added keeps the posture's variance where it is
    stationary = numbers[kernel.CENTRE_NOISE] / (1.0 - numbers[kernel.CENTRE_DECAY] ** 2)
    assert stationary == pytest.approx(np.radians(2.5) ** 2)
    assert numbers[kernel.OUTLIER] == 3.0**2
    assert (numbers[kernel.EARLY], numbers[kernel.IDLE_MOST]) == (5.0, 1.5)
    assert (numbers[kernel.TURN_LEAST], numbers[kernel.SPAN_SHARE]) == (0.4, 0.2)
    assert numbers[kernel.REST_LEAST] == pytest.approx(np.radians(1.5) ** 2)
    assert numbers[kernel.PER_CORRECTED] == pytest.approx(1.0 / np.radians(3.0))
    # a net rotation alone, as large as this, makes a swing as doubtful as a change of posture
    doubt = 1.0 + numbers[kernel.MOST_NET] / numbers[kernel.RETURN_VARIANCE]
    assert doubt == pytest.approx(kernel.MOST_DOUBT)
    sds = np.degrees(np.sqrt(numbers[kernel.CYCLE_VARIANCE : kernel.CYCLE_VARIANCE + 3]))
    np.testing.assert_allclose(sds, [3.0, 2.0, 4.0])
    for index, sd_deg in {kernel.START_VARIANCE: 60.0, kernel.KNOWN_ENOUGH: 3.5,
                          kernel.RETURN_VARIANCE: 5.0, kernel.REOPENED: 10.0}.items():  # fmt: skip
        assert np.degrees(np.sqrt(numbers[index])) == pytest.approx(sd_deg)
    assert np.degrees(numbers[kernel.ALIGNMENT]) == pytest.approx(1.7)
    assert np.degrees(numbers[kernel.SWING_LEAST]) == pytest.approx(2.0)
    assert (numbers[kernel.PERIOD_SHARE], numbers[kernel.DELAY_S]) == (0.4, 0.02)
    assert numbers[kernel.SPEED] == 0.9


def test_the_default_tracker_is_that_of_the_default_model():
    files = Path(__file__).parents[3] / "configs" / "model"
    written = yaml.safe_load((files / "coupled.yaml").read_text())["tracker"]
    del written["_target_"]
    default = {key: value for key, value in vars(PostureTracker()).items() if key != "std_scale"}
    assert {key: list(np.ravel(value)) for key, value in default.items()} == {
        key: list(np.ravel(value)) for key, value in written.items()
    }


def test_the_leak_of_a_recursion_is_its_rate_over_its_steady_angle():
    """y = 0.98 y + 0.01 (u + u'): a constant rate u = 1 ends at y = 1, so the leak is 1 rad/s."""
    assert leak_rad_s(LinearRecursion(50.0, (0.01, 0.01), (0.98, 0.0))) == pytest.approx(1.0)
    assert leak_rad_s(LinearRecursion(50.0, (0.004, 0.004), (1.1, -0.14))) == pytest.approx(5.0)
    assert leak_rad_s(LinearRecursion(50.0, (0.01, 0.01), (1.01, 0.0))) == 0.0


def test_the_leak_of_a_network_counts_all_its_rates_and_angles():
    """p = 0.5 (0.03 u + 0.01 u' + 1.1 p' / 0.5 - 0.14 p'' / 0.5) of a rate of 3 u rad/s.

    A constant u ends at p = 0.5 u, a sixth of the rate.
    """
    model = Narx(50.0, Normalisation(3.0, 0.5, 0.0, 0.0))
    structure, slopes = model.structure, np.array([0.1, 0.2, 0.3])
    weights = np.zeros(structure.n_weights)
    weights[structure.w1] = np.outer(slopes, [0.03, 0.01, 1.1, -0.14]).ravel()
    weights[structure.w2] = 1.0 / (3.0 * slopes)
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(weights))
    assert leak_rad_s(model) == pytest.approx(6.0)
