"""Training sequences never cross a gap, and batches hold only measured samples."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from narx.errors import UserError
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.batch import batch
from narx.windows.sequences import TrainingSequence, contiguous, hold_back

RATE_HZ = 10.0
MODEL = Narx(RATE_HZ, Normalisation(3.0, 0.5))


def numbered(n, rate_hz=RATE_HZ):
    """Signals whose values identify every sample."""
    rates = np.arange(n)[:, None] + np.array([0.1, 0.2, 0.3])
    return SegmentSignals("thigh", rate_hz, rates, np.zeros((n, 3)), np.zeros(3))


def sequence(n, name="a", weight=1.0, rate_hz=RATE_HZ):
    signals = numbered(n, rate_hz)
    return TrainingSequence(name, signals, signals.axis_rates_rad_s / 100.0, weight)


@settings(deadline=None, max_examples=100)
@given(
    keep=st.lists(st.booleans(), max_size=60),
    missing=st.sets(st.integers(0, 59)),
    shortest_s=st.sampled_from([0.0, 0.3, 1.0]),
)
def test_every_stretch_is_one_run_of_usable_samples(keep, missing, shortest_s):
    keep = np.array(keep, dtype=bool)
    n = len(keep)
    signals = numbered(n)
    for k in missing:
        signals.axis_rates_rad_s[k : k + 1, k % 3] = np.nan  # one axis is enough
    usable = keep & ~np.isin(np.arange(n), list(missing))
    parts = contiguous("a", signals, np.arange(3.0 * n).reshape(n, 3), keep, 2.0, shortest_s)
    taken = []
    for part in parts:
        which = part.signals.axis_rates_rad_s[:, 0].astype(int)
        assert np.all(np.diff(which) == 1)
        assert len(which) / RATE_HZ >= shortest_s
        np.testing.assert_array_equal(part.target_rad[:, 0], 3 * which)
        # the sequence is of maximal length
        assert which[0] == 0 or not usable[which[0] - 1]
        assert which[-1] == n - 1 or not usable[which[-1] + 1]
        assert part.weight == 2.0
        taken += list(which)
    assert taken == sorted(set(taken))
    assert usable[taken].all()
    if shortest_s == 0.0:
        assert len(taken) == usable.sum()


def test_a_missing_target_does_not_cut():
    target = np.zeros((40, 3))
    target[10:20] = np.nan
    (part,) = contiguous("a", numbered(40), target, np.ones(40, dtype=bool))
    assert part.duration_s == pytest.approx(4.0)
    assert np.isnan(part.target_rad[10:20]).all()


@pytest.mark.parametrize("fraction", [0.1, 0.25, 0.5])
def test_held_back_samples_are_not_trained_on(fraction):
    sequences = [sequence(40, "a", 2.0), sequence(83, "b")]
    training, validation = hold_back(sequences, fraction)
    for whole, first, last in zip(sequences, training, validation, strict=True):
        joined = np.concatenate([first.signals.axis_rates_rad_s, last.signals.axis_rates_rad_s])
        np.testing.assert_array_equal(joined, whole.signals.axis_rates_rad_s)
        np.testing.assert_array_equal(
            np.concatenate([first.target_rad, last.target_rad]), whole.target_rad
        )
        n = whole.signals.n_samples
        assert last.signals.n_samples == pytest.approx(fraction * n, abs=0.5)
        assert (first.name, last.name) == (whole.name, whole.name)
        assert first.weight == last.weight == whole.weight


def test_nothing_held_back_validates_on_the_training():
    sequences = [sequence(40)]
    assert hold_back(sequences, 0.0) == (sequences, sequences)


@pytest.mark.parametrize("initial_state", ["teacher", "zero"])
def test_padding_has_no_target(initial_state):
    sequences = [sequence(30, weight=2.0), sequence(50)]
    sequences[1].target_rad[7, 1] = np.nan
    side_by_side = batch(sequences, MODEL, initial_state)
    assert side_by_side.rates_rad_s.shape == side_by_side.targets_rad.shape == (2, 50, 3)
    assert not side_by_side.rates_rad_s[0, 30:].any()
    assert side_by_side.targets_rad[0, 30:].isnan().all()
    for row, one in enumerate(sequences):
        n = one.signals.n_samples
        np.testing.assert_array_equal(
            side_by_side.rates_rad_s[row, :n], one.signals.axis_rates_rad_s
        )
        np.testing.assert_array_equal(side_by_side.targets_rad[row, :n], one.target_rad)
    assert side_by_side.weight.tolist() == [2.0, 1.0]
    assert all(tensor.dtype == torch.float64 for tensor in vars(side_by_side).values())
    for state in (side_by_side.state, side_by_side.posture_rad, side_by_side.rates_rad_s):
        assert state.isfinite().all()


def test_from_the_teacher_means_about_his_mean_along_his_first_rate():
    one = sequence(30)
    side_by_side = batch([one], MODEL, "teacher")
    posture = one.target_rad.mean(axis=0)
    np.testing.assert_allclose(side_by_side.posture_rad[0], posture, atol=1e-12)
    rate = one.signals.axis_rates_rad_s[0]
    before = one.target_rad[0] - posture - rate / RATE_HZ
    expected = np.stack([rate / 3.0, before / 0.5, (before - rate / RATE_HZ) / 0.5], axis=-1)
    np.testing.assert_allclose(side_by_side.state[0], expected, atol=1e-12)


def test_from_zero_means_zero():
    side_by_side = batch([sequence(30)], MODEL, "zero")
    assert not side_by_side.state.any()
    assert not side_by_side.posture_rad.any()


def test_an_axis_without_teacher_starts_from_zero():
    one = sequence(30)
    one.target_rad[:, 2] = np.nan
    side_by_side = batch([one], MODEL, "teacher")
    assert side_by_side.posture_rad[0, 2] == 0.0
    assert side_by_side.state.isfinite().all()


def test_sampling_rates_must_be_the_network_s():
    with pytest.raises(UserError, match=r"training: b is sampled at 20 Hz, the network runs at 10"):
        batch([sequence(30), sequence(30, "b", rate_hz=20.0)], MODEL, "teacher")


@pytest.mark.parametrize(("n", "kept"), [(19, 0), (20, 1)])
def test_two_seconds_are_long_enough(n, kept):
    target = np.zeros((n, 3))
    assert len(contiguous("a", numbered(n), target, np.ones(n, dtype=bool))) == kept


def test_the_end_of_every_sequence_is_held_back():
    ((first,), (last,)) = hold_back([sequence(40)], 0.25)
    assert (first.signals.n_samples, last.signals.n_samples) == (30, 10)
