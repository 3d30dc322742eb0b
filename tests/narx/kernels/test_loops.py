"""Without the compiled loops the package falls back to plain torch with a single warning."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from narx.kernels import loops
from narx.network.structure import NarxStructure
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.coupled import CoupledFit

ROOT = Path(__file__).resolve().parents[3]
STRUCTURE = NarxStructure()

# trains, estimates, streams and filters; the output must not depend on the implementation
SCRIPT = """
import sys, warnings
warnings.simplefilter("always")
{prelude}
import numpy as np
import torch
from narx.baselines.complementary_filter import ComplementaryFilter
from narx.baselines.giof import Giof
from narx.inference.start_up import StartUp
from narx.kernels import loops
from narx.method import SegmentSignals
from narx.network.structure import NarxStructure
from narx.network.coupled_loop import coupled_closed_loop
from narx.network.closed_loop import closed_loop
from narx.training.least_squares.coupled import CoupledFit
from narx.training.least_squares.solver import Options, levenberg_marquardt
from narx.training.least_squares.stopping import Stopping

rng = np.random.default_rng(0)
rates = torch.from_numpy(rng.standard_normal((2, 24, 3)))
targets = torch.cumsum(rates, 1) * 0.01
ones, structure = torch.ones(3, dtype=torch.float64), NarxStructure()
scales = dict(rate_scale=ones, angle_scale=0.5 * ones, structure=structure)
fit = CoupledFit(rates, targets, **scales)
start = 0.3 * rng.standard_normal((1, structure.n_weights))
result = levenberg_marquardt(fit, start, Options(Stopping(max_evaluations=4)))
weights = torch.from_numpy(result.weights[0]).requires_grad_()
angles, _ = coupled_closed_loop(weights, rates, **scales)
angles.square().sum().backward()
output, _ = closed_loop(weights.detach(), rates[..., :1], structure=structure)
force = np.tile([0.5, 0.2, 9.8], (24, 1))
signals = SegmentSignals("thigh_right", 100.0, rates[0].numpy(), force, np.zeros(3))
start_up = StartUp().run(rates[0].numpy(), 0.01, StartUp().begin(None))
numbers = [
    result.weights, angles.detach(), weights.grad, output,
    ComplementaryFilter()._estimate(signals)[:, :2], Giof()._estimate(signals)[:, :2], start_up,
]
print(loops.AVAILABLE, *(f"{{float(np.abs(np.asarray(n)).sum()):.9g}}" for n in numbers))
"""

# several sensors side by side, one of them with a lost sample, beside the last one alone
SENSORS = """
from dataclasses import replace
from narx.inference.pretrained import pretrained
from narx.inference.start_up import StartUp
from narx.inference.stream import OrientationStream

shipped, samples = pretrained(), rng.standard_normal((9, 12, 3))
samples[1, 4] = np.nan
for checkpoint in (shipped, replace(shipped, tracker=None, start_up=StartUp(duration_s=0.0))):
    several = OrientationStream(checkpoint.method(), 100.0, n_sensors=9).update_block(samples)
    alone = OrientationStream(checkpoint.method(), 100.0).update_block(samples[8])
    np.testing.assert_array_equal(several.angles_rad[8], alone.angles_rad)
"""

WITHOUT = {
    "numba": "sys.modules['numba'] = None",
    "its inside": "sys.modules['narx.kernels.numba_internals'] = None",
    "vectors": "sys.modules['narx.kernels.lanes'] = None",
}


def run(prelude="", then="", **environment):
    script = SCRIPT.format(prelude=prelude) + then
    answer = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True,
        cwd=ROOT, env={**os.environ, "OMP_NUM_THREADS": "1"} | environment,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    available, *numbers = answer.stdout.split()
    return available == "True", np.array(numbers, dtype=float), answer.stderr


@pytest.fixture(scope="module")
def compiled():
    available, numbers, messages = run()
    assert available
    assert not messages
    return numbers


@pytest.mark.slow
@pytest.mark.parametrize("missing", WITHOUT)
def test_works_without(missing, compiled):
    available, numbers, messages = run(WITHOUT[missing])
    assert not available
    np.testing.assert_allclose(numbers, compiled, rtol=1e-6)
    assert messages.count("RuntimeWarning") == 1
    assert "plain torch operations" in messages


def test_works_with_compilation_switched_off(compiled):
    available, numbers, messages = run(then=SENSORS, NUMBA_DISABLE_JIT="1")
    assert not available
    np.testing.assert_allclose(numbers, compiled, rtol=1e-6)
    assert messages.count("RuntimeWarning") == 1
    assert "NUMBA_DISABLE_JIT" in messages


def some(rng, *shape):
    return torch.from_numpy(0.4 * rng.standard_normal(shape))


@pytest.mark.parametrize("horizon", [7, None])
def test_products_by_torch_are_those_of_the_kernel(horizon, monkeypatch):
    rng = np.random.default_rng(1)
    targets = some(rng, 3, 24)
    targets[0, 8:12] = targets[1, 18:] = targets[2, 13] = torch.nan
    fit = NetworkFit(
        some(rng, 3, 24, 1), targets, some(rng, 3, STRUCTURE.n_state), structure=STRUCTURE,
        horizon=horizon, washout=5, sequence_weights=torch.tensor([1.0, 2.0, 0.5]).double(),
    )  # fmt: skip
    check_products(fit, rng, monkeypatch)


@pytest.mark.parametrize("offset_free", [False, True])
@pytest.mark.parametrize("axis_weights", [(1.0, 1.0, 1.0), (1.0, 0.5, 0.0)])
def test_coupled_products_by_torch_are_those_of_the_kernel(offset_free, axis_weights, monkeypatch):
    rng = np.random.default_rng(2)
    targets, ones = some(rng, 2, 60, 3), torch.ones(3, dtype=torch.float64)
    targets[0, 20:30] = targets[1, 45:, 1] = torch.nan
    fit = CoupledFit(
        some(rng, 2, 60, 3), targets, some(rng, 2, 3, STRUCTURE.n_state), some(rng, 2, 3),
        rate_scale=2.0 * ones, angle_scale=0.5 * ones, structure=STRUCTURE, washout=5,
        offset_free=offset_free, axis_weights=axis_weights,
        sequence_weights=torch.tensor([1.0, 2.0]).double(),
    )  # fmt: skip
    check_products(fit, rng, monkeypatch)


def check_products(fit, rng, monkeypatch):
    weights = some(rng, 2, STRUCTURE.n_weights).numpy()
    ours = np.tril(fit.products(weights))
    monkeypatch.setattr(loops, "AVAILABLE", False)
    by_torch = np.tril(fit.products(weights))
    np.testing.assert_allclose(ours, by_torch, rtol=1e-9, atol=1e-12 * np.abs(by_torch).max())
