"""Networks that differ by the order and signs of their neurons alone are one minimum."""

import numpy as np

from narx.network.structure import NarxStructure
from narx.training.progress import Progress
from narx.training.restarts import Restarts
from narx.training.same_minimum import first_alike

STRUCTURE = NarxStructure(hidden=3)


def reordered(weights, order, signs):
    signs = np.array(signs)[order]
    w1 = weights[STRUCTURE.w1].reshape(3, -1)[order] * signs[:, None]
    b1, w2 = weights[STRUCTURE.b1][order] * signs, weights[STRUCTURE.w2][order] * signs
    return np.concatenate([w1.ravel(), b1, w2, weights[-1:]])


def test_order_and_signs_of_the_neurons_do_not_matter():
    rng = np.random.default_rng(0)
    one, other = rng.normal(size=(2, STRUCTURE.n_weights))
    same = reordered(one, [2, 0, 1], [1, -1, -1]) * (1 + 1e-5 * rng.normal(size=len(one)))
    np.testing.assert_array_equal(
        first_alike(np.array([one, other, same, other, one]), STRUCTURE), [0, 1, 0, 1, 0]
    )


def test_a_small_difference_of_any_weight_counts_and_so_does_divergence():
    rng = np.random.default_rng(1)
    one = rng.normal(size=STRUCTURE.n_weights)
    different = np.tile(one, (STRUCTURE.n_weights + 2, 1))
    different[1:-1] += 0.02 * np.abs(one).max() * np.eye(STRUCTURE.n_weights)
    different[-1, 3] = np.inf
    found = first_alike(np.concatenate([different, different[-1:]]), STRUCTURE)
    np.testing.assert_array_equal(found, np.arange(len(found)))


def test_a_difference_is_relative_to_the_largest_weight_of_its_kind():
    one = np.random.default_rng(3).normal(size=STRUCTURE.n_weights)
    one[STRUCTURE.w2] = [1e-4, 1.0, 2.0]
    other = one.copy()
    other[STRUCTURE.w2.start] *= 2.0
    np.testing.assert_array_equal(first_alike(np.array([one, other]), STRUCTURE), [0, 0])
    other[STRUCTURE.w2.start] *= 50.0
    np.testing.assert_array_equal(first_alike(np.array([one, other]), STRUCTURE), [0, 1])


def test_a_restart_in_the_minimum_of_an_earlier_one_has_its_end():
    rng = np.random.default_rng(2)
    one, end, other = rng.normal(size=(3, STRUCTURE.n_weights))
    run = Restarts(lambda iteration, numbers: None, Progress())
    run.begin(one)
    assert run.end_stage(one, STRUCTURE)
    assert run.end_stage(end, STRUCTURE)
    run.end()
    run.begin(other)
    assert run.end_stage(other, STRUCTURE)
    assert not run.end_stage(reordered(end, [1, 0, 2], [1, 1, -1]), STRUCTURE)
    run.end()
    run.begin(other)
    assert not run.end_stage(reordered(one, [1, 2, 0], [-1, 1, 1]), STRUCTURE)
    run.end()
    np.testing.assert_array_equal(run.ends, [end, end, end])
