"""Lagged windows against a plain loop; lags must not cross gaps or recordings."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch.utils.data import DataLoader

from narx.kinematics.segment_angles import coupled_rates
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.windows.lagged import LaggedWindows
from narx.windows.sequences import TrainingSequence


def plain_loop(rate, angle, input_lags, output_lags):
    rows, targets = [], []
    for k in range(len(angle)):
        if k - output_lags < 0 or k - input_lags + 1 < 0:
            continue
        row = [*(rate[k - lag] for lag in range(input_lags))]
        row = [value for values in row for value in np.atleast_1d(values)]
        row += [angle[k - lag] for lag in range(1, output_lags + 1)]
        if np.isfinite([*row, angle[k]]).all():
            rows.append(row)
            targets.append(angle[k])
    return np.array(rows), np.array(targets)


@settings(deadline=None, max_examples=40)
@given(
    n=st.integers(0, 30),
    input_lags=st.integers(1, 4),
    output_lags=st.integers(1, 4),
    n_inputs=st.integers(1, 3),
    seed=st.integers(0, 99),
)
def test_equals_a_plain_loop(n, input_lags, output_lags, n_inputs, seed):
    rng = np.random.default_rng(seed)
    rate, angle = rng.normal(size=(n, n_inputs)), rng.normal(size=n)
    if n > 8:
        rate[rng.integers(n)] = np.nan
        angle[rng.integers(n)] = np.nan
    windows = LaggedWindows([rate], [angle], input_lags, output_lags)
    rows, targets = plain_loop(rate, angle, input_lags, output_lags)
    assert len(windows) == len(targets)
    assert windows.features.shape[1] == input_lags * n_inputs + output_lags
    np.testing.assert_array_equal(windows.features.numpy().reshape(rows.shape), rows)
    np.testing.assert_array_equal(windows.targets.numpy(), targets)


def test_lags_never_cross_recordings():
    first, second = np.arange(5.0), 100.0 + np.arange(4.0)
    windows = LaggedWindows([first, second], [first, second])
    assert len(windows) == 3 + 2
    for features, target in windows:
        assert torch.all((features < 50) == (target < 50))


def test_works_with_a_data_loader():
    signal = np.arange(10.0)
    features, targets = next(iter(DataLoader(LaggedWindows([signal], [signal]), batch_size=8)))
    assert features.shape == (8, 4)
    assert targets.shape == (8,)
    assert features[0].tolist() == [2.0, 1.0, 1.0, 0.0]


def test_refuses_sequences_of_different_lengths():
    with pytest.raises(ValueError, match="output has shape"):
        LaggedWindows([np.zeros(4)], [np.zeros(5)])
    with pytest.raises(ValueError, match="lags must be positive"):
        LaggedWindows([np.zeros(4)], [np.zeros(4)], input_lags=0)


@pytest.mark.parametrize("coupled", [False, True])
def test_windows_of_sequences_are_normalised_about_the_mean_angle(coupled):
    """Row by row: coupled rates, offset and scale, the deviation from the mean, the weights."""
    rng = np.random.default_rng(1)
    offsets = (0.0, 0.0) if coupled else (0.1, -0.05)
    model = Narx(50.0, Normalisation(3.0, 0.5, *offsets), None, odd=coupled, coupled=coupled)
    sequences = []
    for n, weight in ((30, 2.0), (20, 0.5)):
        rates, angles = rng.normal(size=(n, 3)), 0.3 + 0.4 * rng.normal(size=(n, 3))
        angles[5, 1] = np.nan
        signals = SegmentSignals("thigh", 50.0, rates, np.zeros((n, 3)), None)
        sequences.append(TrainingSequence("a", signals, angles, weight))
    found = LaggedWindows.of_sequences(model, sequences, (1.0, 0.0, 0.25))
    features, targets, weights = [], [], []
    for one in sequences:
        rates, angles = one.signals.axis_rates_rad_s, one.target_rad
        if coupled:
            rates = coupled_rates(rates, angles)
        for axis, weight in ((0, 1.0), (2, 0.25)):
            v = (rates[:, axis] - offsets[0]) / 3.0
            p = (angles[:, axis] - np.nanmean(angles[:, axis]) - offsets[1]) / 0.5
            rows, values = plain_loop(v, p, 2, 2)
            features.append(rows)
            targets.append(values)
            weights.append(np.full(len(values), weight * one.weight))
    np.testing.assert_allclose(found.features, np.concatenate(features), atol=1e-12)
    np.testing.assert_allclose(found.targets, np.concatenate(targets), atol=1e-12)
    np.testing.assert_allclose(found.weights, np.concatenate(weights), atol=1e-12)
