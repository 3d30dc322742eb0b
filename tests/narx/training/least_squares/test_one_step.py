"""The one-step fit on lagged windows against forward differentiation of plain torch operations."""

import numpy as np
import pytest
import torch

from narx.kernels import loops
from narx.network.closed_loop import closed_loop_by_torch
from narx.network.structure import NarxStructure
from narx.training.least_squares.one_step import OneStepFit
from narx.windows.lagged import LaggedWindows

DEFAULT = NarxStructure()


def windows_of(n_sequences=2, n_samples=300, structure=DEFAULT, seed=0):
    rng = np.random.default_rng(seed)
    inputs = [rng.standard_normal(n_samples + i) for i in range(n_sequences)]
    outputs = [rng.standard_normal(n_samples + i) for i in range(n_sequences)]
    outputs[0][40:43] = np.nan
    weights = np.linspace(0.5, 2.0, n_sequences)
    lags = structure.input_lags, structure.output_lags
    return LaggedWindows(inputs, outputs, *lags, weights.tolist())


def numbers(structure=DEFAULT, n_starts=3, seed=1):
    return 0.4 * np.random.default_rng(seed).standard_normal((n_starts, structure.n_weights))


@pytest.mark.parametrize("n_starts", [1, 3, 11])
@pytest.mark.parametrize(
    "structure", [DEFAULT, NarxStructure(1, 1, 1, 1), NarxStructure(6, 1, 3, 3)]
)
@pytest.mark.parametrize("available", [True, False])
def test_products_are_those_of_the_differentiated_residuals(
    structure, n_starts, available, monkeypatch
):
    monkeypatch.setattr(loops, "AVAILABLE", available)
    windows = windows_of(structure=structure)
    fit = OneStepFit(windows, structure)
    starts = numbers(structure, n_starts)
    products = fit.products(starts)
    assert products.shape == (n_starts, structure.n_weights + 1, structure.n_weights + 1)
    roots, targets = windows.weights.sqrt(), windows.targets

    def residuals(w):
        w1 = w[structure.w1].reshape(structure.hidden, -1)
        hidden = torch.tanh(windows.features @ w1.T + w[structure.b1])
        return roots * (hidden @ w[structure.w2] + w[structure.b2] - targets)

    for start, found in zip(starts, products, strict=True):
        w = torch.from_numpy(start)
        rows = torch.cat([torch.func.jacfwd(residuals)(w), residuals(w)[:, None]], dim=1)
        expected = np.tril((rows.T @ rows).numpy())
        np.testing.assert_allclose(np.tril(found), expected, rtol=1e-9, atol=1e-9)
    assert fit.n_residuals == len(windows)
    assert fit.total_weight == pytest.approx(float(windows.weights.sum()))


def test_a_window_is_one_step_of_the_closed_loop():
    windows, w = windows_of(), torch.from_numpy(numbers()[0])
    fit = OneStepFit(windows, DEFAULT)
    predicted = fit.residuals(w) / windows.weights.sqrt() + windows.targets
    for k in (0, 10, 200):
        v, *state = windows.features[k]
        step, _ = closed_loop_by_torch(w, v.view(1, 1), torch.stack(state), structure=DEFAULT)
        torch.testing.assert_close(predicted[k], step[0])


def test_every_window_of_many_counts():
    """More than the share of one thread, and no whole number of vectors."""
    fit, w = OneStepFit(windows_of(2, 9000), DEFAULT), numbers(n_starts=1)
    assert fit.n_residuals > 16384
    squares = fit.residuals(torch.from_numpy(w[0])).square().sum()
    assert fit.products(w)[0, -1, -1] == pytest.approx(float(squares), rel=1e-9)


@pytest.mark.concurrency
def test_threads_do_not_change_a_bit():
    fit = OneStepFit(windows_of(4, 9000), DEFAULT)
    threads = torch.get_num_threads()
    results = []
    try:
        for n in (1, 2, 3):
            torch.set_num_threads(n)
            results.append(fit.products(numbers(n_starts=5)))
    finally:
        torch.set_num_threads(threads)
    np.testing.assert_array_equal(results[0], results[1])
    np.testing.assert_array_equal(results[0], results[2])


def test_no_window_no_squares():
    fit = OneStepFit(LaggedWindows([np.zeros(2)], [np.zeros(2)]), DEFAULT)
    assert (fit.n_residuals, fit.total_weight) == (0, 0.0)
    assert not fit.products(numbers()).any()


def test_windows_of_other_lags_are_refused():
    with pytest.raises(ValueError, match="windows of 4 values, a network of 6"):
        OneStepFit(windows_of(), NarxStructure(3, 1, 3, 3))
