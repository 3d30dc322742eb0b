"""Forward and backward pass of a tracker: reversal of time, and the average of both."""

import numpy as np
import pytest

from narx.inference.tracker import LinearRecursion, PostureTracker
from narx.inference.tracking import Tracked, Tracking, follow
from narx.kernels import tracker_layout as kernel


class _Passes:
    """A tracking with a given output of each pass."""

    def __init__(self, output, back=None):
        self._output, self._back = output, back

    def follow(self, rates, force):
        return self._output

    def time_reversed(self):
        return _Passes(self._back.reversed())


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
