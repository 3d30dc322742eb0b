"""The compiled recurrence against a plain one, for all shapes of its arguments."""

import numpy as np
import pytest
import torch

from narx.network.closed_loop import closed_loop, closed_loop_by_torch
from narx.network.structure import NarxStructure

DEFAULT = NarxStructure()
WIDE = NarxStructure(hidden=2, n_inputs=2, input_lags=3, output_lags=1)


def problem(structure, n_sequences, n_samples, seed=0, scale=0.4):
    rng = np.random.default_rng(seed)
    weights = torch.from_numpy(scale * rng.standard_normal(structure.n_weights))
    inputs = torch.from_numpy(rng.standard_normal((n_sequences, n_samples, structure.n_inputs)))
    state = torch.from_numpy(rng.standard_normal((n_sequences, structure.n_state)))
    return weights, inputs, state


def by_numpy(weights, inputs, state, structure):
    """One sequence, computed directly from the equation."""
    w = weights.numpy()
    w1 = w[structure.w1].reshape(structure.hidden, structure.n_features)
    past_v = list(state[: structure.n_input_state].numpy().reshape(-1, structure.n_inputs))
    past_p = list(state[structure.n_input_state :].numpy())
    outputs = []
    for v in inputs.numpy():
        x = np.concatenate([v, *past_v, past_p])
        p = w[structure.b2] + w[structure.w2] @ np.tanh(w1 @ x + w[structure.b1])
        outputs.append(p)
        past_v = [v, *past_v][: structure.input_lags - 1]
        past_p = [p, *past_p][: structure.output_lags]
    return np.array(outputs), np.concatenate([*past_v, past_p])


@pytest.mark.parametrize("structure", [DEFAULT, WIDE], ids=["default", "wide"])
@pytest.mark.parametrize("tanh", ["rational", "exact"])
@pytest.mark.parametrize("n_sequences", [1, 11])
def test_equals_a_plain_recurrence(structure, tanh, n_sequences):
    weights, inputs, state = problem(structure, n_sequences, 300)
    outputs, final = closed_loop(weights, inputs, state, structure=structure, tanh=tanh)
    for i in range(n_sequences):
        expected, expected_final = by_numpy(weights, inputs[i], state[i], structure)
        np.testing.assert_allclose(outputs[i], expected, rtol=0, atol=1e-10)
        np.testing.assert_allclose(final[i], expected_final, rtol=0, atol=1e-10)


@pytest.mark.parametrize("n_rows", [1, 2, 3])
def test_each_row_of_weights_is_of_one_sequence(n_rows):
    _, inputs, state = problem(DEFAULT, n_rows, 100)
    rows = torch.stack([problem(DEFAULT, 1, 1, seed=k)[0] for k in range(n_rows)])
    outputs, _ = closed_loop(rows, inputs, state, structure=DEFAULT)
    for k in range(n_rows):
        alone, _ = closed_loop(rows[k], inputs[k : k + 1], state[k : k + 1], structure=DEFAULT)
        np.testing.assert_allclose(outputs[k], alone[0], rtol=0, atol=1e-12)


def nearly_an_integrator(n=20000):
    """Weights with a pole at 0.999, so that errors of the activation accumulate."""
    weights = torch.zeros(DEFAULT.n_weights, dtype=torch.float64)
    w1 = torch.tensor([[0.02, 0.02, 0.1, 0.0], [0.0, 0.01, 0.2, 0.0], [0.01, 0.0, 0.1, 0.0]])
    weights[DEFAULT.w1] = w1.double().flatten()
    weights[DEFAULT.w2] = 0.999 / 3 / w1[:, 2].double()
    inputs = torch.from_numpy(np.random.default_rng(3).standard_normal((1, n, 1)))
    return weights, inputs


def test_rational_tanh_is_good_enough_for_an_integrator():
    weights, inputs = nearly_an_integrator()
    fast, _ = closed_loop(weights, inputs, structure=DEFAULT)
    exact, _ = closed_loop(weights, inputs, structure=DEFAULT, tanh="exact")
    assert exact.abs().max() > 0.1
    assert (fast - exact).abs().max() < 1e-8


@pytest.mark.parametrize("pieces", [[1] * 5 + [295], [137, 163], [0, 300], [128, 128, 44]])
def test_pieces_give_the_same_as_the_whole(pieces):
    weights, inputs, state = problem(DEFAULT, 9, 300)
    whole, whole_final = closed_loop(weights, inputs, state, structure=DEFAULT)
    parts = []
    for piece in inputs.split(pieces, dim=1):
        part, state = closed_loop(weights, piece, state, structure=DEFAULT)
        parts.append(part)
    assert torch.equal(torch.cat(parts, dim=1), whole)
    assert torch.equal(state, whole_final)


@pytest.mark.concurrency
def test_batch_shape_and_threads_do_not_matter():
    weights, inputs, state = problem(DEFAULT, 24, 150)
    whole, _ = closed_loop(weights, inputs, state, structure=DEFAULT)
    shaped, final = closed_loop(
        weights, inputs.reshape(2, 3, 4, 150, 1), state.reshape(2, 3, 4, 3), structure=DEFAULT
    )
    assert shaped.shape == (2, 3, 4, 150)
    assert final.shape == (2, 3, 4, 3)
    assert torch.equal(shaped.reshape(24, 150), whole)
    threads = torch.get_num_threads()
    try:
        for n in (1, 2, 5):
            torch.set_num_threads(n)
            again, _ = closed_loop(weights, inputs, state, structure=DEFAULT)
            assert torch.equal(again, whole)
    finally:
        torch.set_num_threads(threads)
    alone, _ = closed_loop(weights, inputs[5], state[5], structure=DEFAULT)
    np.testing.assert_allclose(alone, whole[5], rtol=0, atol=1e-12)


def test_weights_of_their_own_for_each_sequence():
    _, inputs, state = problem(DEFAULT, 3, 60)
    weights = torch.stack([problem(DEFAULT, 1, 1, seed=i)[0] for i in range(3)])
    together, _ = closed_loop(weights, inputs, state, structure=DEFAULT)
    for i in range(3):
        alone, _ = closed_loop(weights[i], inputs[i], state[i], structure=DEFAULT)
        np.testing.assert_allclose(together[i], alone, rtol=0, atol=1e-12)


@pytest.mark.parametrize("n_sequences", [1, 3])
def test_gradcheck(n_sequences):
    arguments = problem(DEFAULT, n_sequences, 7)
    for argument in arguments:
        argument.requires_grad_()
    assert torch.autograd.gradcheck(lambda *a: closed_loop(*a, structure=DEFAULT), arguments)


@pytest.mark.parametrize("structure", [DEFAULT, WIDE], ids=["default", "wide"])
def test_gradient_equals_autograd_through_an_explicit_loop(structure):
    weights, inputs, state = arguments = problem(structure, 3, 200)
    for argument in arguments:
        argument.requires_grad_()
    rng = torch.Generator().manual_seed(0)
    gradients = []
    for run in (closed_loop, closed_loop_by_torch):
        outputs, final = run(weights, inputs, state, structure=structure)
        rng.manual_seed(0)
        ask = torch.randn(outputs.shape, generator=rng, dtype=torch.float64)
        ask_final = torch.randn(final.shape, generator=rng, dtype=torch.float64)
        total = (outputs * ask).sum() + (final * ask_final).sum()
        gradients.append(torch.autograd.grad(total, arguments))
    for ours, theirs in zip(*gradients, strict=True):
        torch.testing.assert_close(ours, theirs, rtol=1e-10, atol=1e-10)


def test_short_and_empty_inputs():
    weights, inputs, state = problem(DEFAULT, 2, 2)
    for n in (1, 2):
        outputs, final = closed_loop(weights, inputs[:, :n], state, structure=DEFAULT)
        expected, expected_final = by_numpy(weights, inputs[0, :n], state[0], DEFAULT)
        np.testing.assert_allclose(outputs[0], expected, atol=1e-12)
        np.testing.assert_allclose(final[0], expected_final, atol=1e-12)
    outputs, final = closed_loop(weights, inputs[:, :0], state, structure=DEFAULT)
    assert outputs.shape == (2, 0)
    assert torch.equal(final, state)
    outputs, final = closed_loop(weights, inputs[:0], state[:0], structure=DEFAULT)
    assert outputs.shape == (0, 2)
    assert final.shape == (0, 3)


@pytest.mark.parametrize("n_sequences", [1, 3])
def test_a_missing_input_is_not_hidden(n_sequences):
    weights, inputs, state = problem(DEFAULT, n_sequences, 50)
    inputs[0, 20] = torch.nan
    outputs, final = closed_loop(weights, inputs, state, structure=DEFAULT)
    assert outputs[0, :20].isfinite().all()
    assert outputs[0, 20:].isnan().all()
    assert final[0, 1:].isnan().all()
    assert outputs[1:].isfinite().all()


@pytest.mark.parametrize("tanh", ["rational", "exact"])
def test_huge_inputs_stay_within_the_bound_of_tanh(tanh):
    weights, inputs, state = problem(DEFAULT, 3, 50)
    inputs *= 1e300
    outputs, _ = closed_loop(weights, inputs, state, structure=DEFAULT, tanh=tanh)
    bound = weights[DEFAULT.w2].abs().sum() + weights[DEFAULT.b2].abs()
    assert (outputs.abs() <= bound + 1e-12).all()
    expected, _ = by_numpy(weights, inputs[0], state[0], DEFAULT)
    np.testing.assert_allclose(outputs[0], expected, atol=1e-10)


def test_float32_in_and_out():
    weights, inputs, state = problem(DEFAULT, 3, 100)
    precise, _ = closed_loop(weights, inputs, state, structure=DEFAULT)
    outputs, final = closed_loop(weights.float(), inputs.float(), state.float(), structure=DEFAULT)
    assert outputs.dtype == final.dtype == torch.float32
    torch.testing.assert_close(outputs.double(), precise, rtol=0, atol=1e-5)


def test_shapes_that_do_not_fit_are_refused():
    weights, inputs, state = problem(DEFAULT, 2, 5)
    with pytest.raises(ValueError, match="weights"):
        closed_loop(weights[1:], inputs, state, structure=DEFAULT)
    with pytest.raises(ValueError, match="inputs"):
        closed_loop(weights, inputs[..., 0], state, structure=DEFAULT)
    with pytest.raises(ValueError, match="state"):
        closed_loop(weights, inputs, state[:, 1:], structure=DEFAULT)
    with pytest.raises(ValueError, match="hidden"):
        NarxStructure(hidden=0)
