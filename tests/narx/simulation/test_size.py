"""Estimates of a data set's size before it is simulated."""

import pytest

from narx.errors import UserError
from narx.simulation.size import MOST_GIB, check_size, longest_walk_s


def test_the_longest_walk_has_the_longest_stands_and_most_steps():
    """A second a step, and a stand before and after."""
    assert longest_walk_s((3.0, 5.0), (3, 7)) == 2 * 5.0 + 7.0


def test_memory_is_measured_in_binary_gigabytes():
    """1300 bytes a sample: 2.5 GiB are 68.8 minutes at 500 Hz."""
    longest_s = MOST_GIB * 2**30 / 1300.0 / 500.0
    assert longest_s == pytest.approx(68.8 * 60.0, rel=0.01)
    check_size(1, 0.99 * longest_s, 500.0)
    with pytest.raises(UserError, match="takes some 2"):
        check_size(1, 1.01 * longest_s, 500.0)


def test_a_hundred_thousand_trials_are_simulated_and_not_one_more():
    check_size(100_000, 10.0, 500.0)
    with pytest.raises(UserError, match="100001 trials"):
        check_size(100_001, 10.0, 500.0)
