"""The posture of the start-up as an estimate."""

import numpy as np

from narx.baselines.constant import Constant

KNOWN = np.array([0.3, -0.2, 0.4])


def test_it_is_the_mean_angle_of_the_first_steps_about_a_known_start(motion):
    walk = motion("walking", duration_s=30.0)
    angles = Constant().estimate(walk.changed(initial_angles_rad=KNOWN).signals)
    np.testing.assert_array_equal(angles, np.tile(angles[0], (walk.signals.n_samples, 1)))
    # whole strides of 0.9 Hz, when the steps have their full size
    mean = walk.angles_rad[200:1200].mean(axis=0)
    np.testing.assert_allclose(angles[0], KNOWN + mean, atol=0.02)


def test_a_recording_that_ends_before_the_average_begins_has_no_posture(motion):
    walk = motion("walking", duration_s=2.0).changed(initial_angles_rad=KNOWN).signals
    assert not Constant().estimate(walk).any()


def test_another_start_up_averages_over_other_steps(motion):
    walk = motion("walking", duration_s=20.0).signals
    other = Constant({"duration_s": 6.0, "averaging_s": 3.0}).estimate(walk)[0]
    assert np.abs(other - Constant().estimate(walk)[0]).max() > 1e-4
