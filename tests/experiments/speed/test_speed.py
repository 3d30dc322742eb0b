"""The speed benchmark runs, and the compared solvers do the same work as the engine."""

import json
import subprocess
import sys

import numpy as np
import pytest
import torch

from narx.experiments.speed import peers as peers
from narx.experiments.speed import solvers as solvers
from narx.experiments.speed import streams as streams
from narx.experiments.speed.__main__ import timed
from narx.experiments.speed.compiled_c import CompiledC
from narx.experiments.speed.task import gait_like, open_loop_fit, random_starts
from narx.network.closed_loop import closed_loop
from narx.network.structure import NarxStructure
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.solver import Options, levenberg_marquardt
from narx.training.least_squares.stopping import Stopping

DEFAULT = NarxStructure()
RATIOS = (
    "closed_loop_jacobian_vs_torch_loop",
    "closed_loop_jacobian_vs_jax_scan",
    "closed_loop_jacobian_vs_pyrenn",
    "closed_loop_jacobian_vs_c",
    "open_loop_lm_vs_scipy",
    "open_loop_lm_vs_torch_levenberg_marquardt",
    "rollout_1_vs_torchscript",
    "rollout_180_vs_torchscript",
    "multi_start_vs_torch_loop",
)


@pytest.fixture
def problem():
    v, target = gait_like(300)
    weights = 0.3 * np.random.default_rng(0).standard_normal(19)
    fit = NetworkFit(torch.from_numpy(v)[:, None], torch.from_numpy(target), structure=DEFAULT)
    products = fit.products(weights[None])[0]
    return v, target, weights, np.tril(products) + np.tril(products, -1).T


@pytest.mark.skipif(not CompiledC.available(), reason="no gcc")
def test_c_does_the_same(problem, tmp_path):
    v, target, weights, products = problem
    c = CompiledC(tmp_path)
    theirs = c.closed_loop_products(weights, v, target)()
    np.testing.assert_allclose(theirs[:20, :20], products, rtol=1e-9, atol=1e-9)
    for n_channels in (1, 21):
        signals = np.linspace(0.5, 1.0, n_channels)[:, None] * v
        ours, _ = closed_loop(
            torch.from_numpy(weights), torch.from_numpy(signals)[..., None], structure=DEFAULT
        )
        np.testing.assert_allclose(c.rollout(weights, signals)(), ours, atol=1e-12)
        scripted = peers.torchscript_rollout(weights, signals)()
        np.testing.assert_allclose(scripted.T, ours, atol=1e-12)


def test_torch_does_the_same(problem):
    v, target, weights, products = problem
    for script in (False, True):
        gradient = peers.torch_gradient(weights, v, target, script)()
        np.testing.assert_allclose(gradient, products[19, :19], rtol=1e-9, atol=1e-9)


def test_streams_are_timed_by_the_sample(monkeypatch):
    monkeypatch.setattr(streams, "SAMPLES", 20)
    monkeypatch.setattr(streams, "SENSORS", 5)
    works = streams.works(peers=True)
    kinds = {name.split(".")[0] for name in works}
    assert kinds == {"stream", "stream_tracked"}
    for name, (work, factor) in works.items():
        work()
        assert factor == (1 / 5 if name.endswith("in_step") else 1 / 20)


SOLVERS = {
    "scipy": solvers.scipy_open_loop,
    "torch_levenberg_marquardt": solvers.torch_levenberg_marquardt_open_loop,
    "optimistix": solvers.optimistix_open_loop,
}


@pytest.mark.parametrize("name", SOLVERS)
def test_solvers_fit_the_same_problem_and_stop_at_the_level(problem, name):
    v, target, weights, _ = problem
    train = SOLVERS[name](v, target, 200)
    if train is None:
        pytest.skip(f"{name} is not installed")
    fit = open_loop_fit(v, target)
    start = fit.products(weights[None])[0, -1, -1] / len(v)
    level = 1e-3 * start
    trained = train(weights, level)
    assert trained.mean_square <= level
    # the level is met within the first steps, and then no more are taken
    longer = train(weights, 0.01 * level)
    assert trained.n_steps <= longer.n_steps < 200
    assert longer.mean_square <= 0.01 * level < trained.mean_square
    at_once = train(weights, 2.0 * start)
    assert at_once.n_steps <= 2


def test_the_engine_ends_no_higher_than_scipy_from_random_starts():
    """From distant starts the minimum reached is random, so means over many starts are used."""
    v, target = gait_like(300)
    fit = open_loop_fit(v, target)
    starts = random_starts(16, np.random.default_rng(1))
    train = solvers.scipy_open_loop(v, target, 1000)
    theirs = np.array([train(start, 0.0).mean_square for start in starts])
    options = Options(Stopping(max_evaluations=1000, gradient=0.0, step=0.0))
    ours = 2.0 * levenberg_marquardt(fit, starts, options).cost / len(v)
    assert np.exp(np.mean(np.log(ours / theirs))) < 1.05
    assert np.median(ours) < 1.05 * np.median(theirs)


def test_scipy_reports_its_final_cost(problem):
    v, target, weights, _ = problem
    ours = levenberg_marquardt(
        open_loop_fit(v, target),
        weights,
        Options(Stopping(max_evaluations=1)),
    )
    # the first evaluation is the start: the same cost as ours there
    first = solvers.scipy_open_loop(v, target, 50)(weights, np.inf)
    np.testing.assert_allclose(
        first.mean_square * len(v) / 2.0, ours.history["cost"][0, 0], rtol=1e-9
    )


@pytest.mark.skipif(not peers.installed("jax"), reason="no jax")
def test_jax_does_the_same(problem):
    v, target, weights, products = problem
    work = peers.jax_jacobian(weights, v, target, 1)
    matrix, gradient = work()
    np.testing.assert_allclose(matrix, products[:19, :19], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(gradient, products[19, :19], rtol=1e-9, atol=1e-9)


def test_timing():
    calls = []
    timing = timed(lambda: calls.append(0), 4, scale=1e6)
    assert len(calls) == 5
    assert timing.q25_s <= timing.median_s <= timing.q75_s
    assert timing.n == 4


@pytest.mark.slow
def test_command_without_peers(tmp_path):
    overrides = [
        "peers=false", "first_use=false", "n_samples=400", "n_rollout_samples=600",
        "n_channels=9", "n_starts=4", "n_cost_starts=2", "iterations=3", "repeats=1",
        "slow_repeats=1", "slow_samples=200", f"hydra.run.dir={tmp_path}",
    ]  # fmt: skip
    run = subprocess.run(
        [sys.executable, "-m", "narx.experiments.speed.__main__", *overrides],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    report = json.loads((tmp_path / "speed.json").read_text())
    assert all(report[name] is None for name in RATIOS)
    assert report["timings"]["multi_start.narx"]["median_s"] > 0
