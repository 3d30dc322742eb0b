"""Measure the engine and its peers in one run, and print the numbers quoted in the README.

python -m experiments.speed

OPENBLAS_CORETYPE and OPENBLAS_L2_SIZE are unset before numpy is imported: if they are set, numpy is
slower than necessary, and so are the peers that use it.
"""

# ruff: noqa: E402
import os

from narx.types import FloatArray

for _name in ("OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE"):
    os.environ.pop(_name, None)

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from omegaconf import DictConfig

from narx.experiments.command import command, run_directory
from narx.experiments.runs.record import environment, seed_everything, write_json
from narx.experiments.speed import peers as peers
from narx.experiments.speed import solvers as solvers
from narx.experiments.speed import streams as streams
from narx.experiments.speed.compiled_c import CompiledC
from narx.experiments.speed.first_use import first_use
from narx.experiments.speed.task import (
    STRUCTURE,
    gait_like,
    open_loop_fit,
    open_then_closed,
    random_starts,
)
from narx.network.closed_loop import closed_loop
from narx.network.coupled_loop import coupled_closed_loop
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.solver import Options, levenberg_marquardt
from narx.training.least_squares.stopping import Stopping
from narx.training.multi_start import MultiStartResult, multi_start


@dataclass(frozen=True)
class Timing:
    """Median and quartiles of repeated runs.

    Parameters
    ----------
    median_s, q25_s, q75_s : float
        Of the times, s.
    n : int
        Runs.
    """

    median_s: float
    q25_s: float
    q75_s: float
    n: int


def timed(work: Callable[[], Any], repeats: int, scale: float = 1.0) -> Timing:
    """Time a piece of work, after one warm-up run.

    Parameters
    ----------
    work : callable
        Work to time.
    repeats : int
        Number of runs.
    scale : float
        Factor on the times, for work that is a part of the whole.

    Returns
    -------
    Timing
        Median and quartiles.
    """
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(scale * (time.perf_counter() - start))
    q25, median, q75 = np.quantile(times, (0.25, 0.5, 0.75))
    return Timing(float(median), float(q25), float(q75), repeats)


class _Bench:
    """Signals, a trained network, and the timings."""

    def __init__(self, cfg: DictConfig) -> None:
        self.cfg = cfg
        self.timings: dict[str, Timing] = {}
        self.v, self.target = gait_like(cfg.n_samples)
        self.inputs = torch.from_numpy(self.v)[:, None]
        self.targets = torch.from_numpy(self.target)
        self.rng = np.random.default_rng(cfg.seed)
        self.open = open_loop_fit(self.v, self.target)
        self.closed = NetworkFit(self.inputs, self.targets, structure=STRUCTURE)
        stages = open_then_closed(self.v, self.target)
        starts = random_starts(16, self.rng)
        self.weights = multi_start(stages, starts, self.closed).weights

    def time(
        self, name: str, work: Callable[[], Any] | None, slow: bool = False, factor: float = 1.0
    ) -> None:
        if work is not None:
            repeats = self.cfg.slow_repeats if slow else self.cfg.repeats
            self.timings[name] = timed(work, repeats, factor)
            print(f"  {name:<44} {1e3 * self.timings[name].median_s:12.4g} ms", flush=True)

    def ratio(self, peer: str, own: str) -> float | None:
        if peer not in self.timings or own not in self.timings:
            return None
        return self.timings[peer].median_s / self.timings[own].median_s


def _closed_loop_jacobian(bench: _Bench, c: CompiledC | None) -> None:
    w, v, target = bench.weights, bench.v, bench.target
    bench.time("closed_loop_jacobian.narx", lambda: bench.closed.products(w[None]))
    eight = np.repeat(w[None], 8, axis=0)
    bench.time("closed_loop_jacobian.narx_8_starts", lambda: bench.closed.products(eight))
    if c is not None:
        bench.time("closed_loop_jacobian.c", c.closed_loop_products(w, v, target))
        # alternating, so that load on the machine affects both equally
        bench.time("closed_loop_jacobian.narx", lambda: bench.closed.products(w[None]))
    if not bench.cfg.peers:
        return
    for unroll in (1, 8):
        work = peers.jax_jacobian(w, v, target, unroll)
        bench.time(f"closed_loop_jacobian.jax_scan_unroll_{unroll}", work)
    for script in (True, False):
        name = "torch_scripted_loop" if script else "torch_eager_loop"
        bench.time(
            f"closed_loop_jacobian.{name}", peers.torch_gradient(w, v, target, script), slow=True
        )
    bench.time("closed_loop_jacobian.pyrenn", peers.pyrenn_jacobian(v, target), slow=True)


def _open_loop_training(bench: _Bench) -> dict[str, Any]:
    cfg, n = bench.cfg, bench.cfg.iterations
    start = random_starts(1, np.random.default_rng(cfg.seed))[0]
    options = Options(Stopping(max_evaluations=n, gradient=0.0, step=0.0))
    bench.time("open_loop_lm.narx", lambda: levenberg_marquardt(bench.open, start, options))
    if not cfg.peers:
        return {}
    for name, train in _solvers(bench, n).items():
        # some stop early: all times are per step
        factor = n / max(train(start, 0.0).n_steps, 1)
        bench.time(f"open_loop_lm.{name}", partial(train, start, 0.0), slow=True, factor=factor)
    return _race(bench)


def _solvers(bench: _Bench, n: int) -> dict[str, solvers.Train]:
    made = {
        "scipy": solvers.scipy_open_loop(bench.v, bench.target, n),
        "torch_levenberg_marquardt": solvers.torch_levenberg_marquardt_open_loop(
            bench.v, bench.target, n
        ),
        "optimistix": solvers.optimistix_open_loop(bench.v, bench.target, n),
    }
    return {name: train for name, train in made.items() if train is not None}


def _race(bench: _Bench) -> dict[str, Any]:
    """Time until the same mean square of one-step errors is reached from the same starts."""
    cfg = bench.cfg
    starts = random_starts(cfg.n_cost_starts, np.random.default_rng(cfg.seed))
    level, n = 1e-6, 1000
    result: dict[str, Any] = {"mean_square": level, "n_starts": len(starts)}
    squares = level * bench.open.n_residuals
    options = Options(Stopping(max_evaluations=n, gradient=0.0, step=0.0, squares=squares))

    def narx(start: FloatArray, level: float) -> solvers.Trained:
        found = levenberg_marquardt(bench.open, start, options)
        mean_square = 2.0 * float(found.cost[0]) / bench.open.n_residuals
        return solvers.Trained(mean_square, int(found.n_evaluations[0]))

    for name, train in {"narx": narx, **_solvers(bench, n)}.items():
        train(starts[0], level)
        times, steps = [], []
        for start in starts:
            begin = time.perf_counter()
            trained = train(start, level)
            if trained.mean_square <= level:
                times.append(time.perf_counter() - begin)
                steps.append(trained.n_steps)
        result[name] = {
            "reached": len(times),
            "median_s": float(np.median(times)) if times else None,
            "median_steps": float(np.median(steps)) if steps else None,
        }
        print(f"  race to {level:g}, {name}: {result[name]}", flush=True)
    return result


def _rollout(bench: _Bench, c: CompiledC | None) -> dict[str, float]:
    cfg = bench.cfg
    v, _ = gait_like(cfg.n_rollout_samples)
    w = torch.from_numpy(bench.weights)
    errors = {}
    for n_channels in (1, cfg.n_channels):
        gains = np.linspace(0.5, 1.0, n_channels)[::-1, None]
        signals = np.ascontiguousarray(gains * v)
        inputs = torch.from_numpy(signals)[..., None]
        name = f"rollout_{n_channels}"

        def work(inputs: torch.Tensor = inputs) -> torch.Tensor:
            return closed_loop(w, inputs, structure=STRUCTURE)[0]

        bench.time(f"{name}.narx", work, slow=n_channels > 1)
        threads = torch.get_num_threads()
        torch.set_num_threads(1)
        bench.time(f"{name}.narx_1_thread", work, slow=n_channels > 1)
        torch.set_num_threads(threads)
        if c is not None:
            bench.time(f"{name}.c", c.rollout(bench.weights, signals), slow=n_channels > 1)
        if cfg.peers:
            part = min(cfg.slow_samples, cfg.n_rollout_samples)
            scripted = peers.torchscript_rollout(bench.weights, signals[:, :part])
            timing = timed(scripted, cfg.slow_repeats, cfg.n_rollout_samples / part)
            bench.timings[f"{name}.torchscript"] = timing
            print(f"  {name + '.torchscript':<44} {1e3 * timing.median_s:12.4g} ms", flush=True)
        exact, _ = closed_loop(w, inputs[:8], structure=STRUCTURE, tanh="exact")
        errors[name] = float((work(inputs[:8]) - exact).abs().max())
    return errors


def _multi_start(bench: _Bench) -> dict[str, float]:
    cfg = bench.cfg
    options = Options(Stopping(max_evaluations=cfg.iterations, gradient=0.0, step=0.0))
    stages = open_then_closed(bench.v, bench.target)
    starts = random_starts(cfg.n_starts, np.random.default_rng(cfg.seed))

    def work() -> MultiStartResult:
        return multi_start(stages, starts, bench.closed, options)

    bench.time("multi_start.narx", work, slow=True)
    loop = bench.timings.get("closed_loop_jacobian.torch_scripted_loop")
    if loop is not None:
        # time of its closed-loop gradients alone; the table marks it as a product
        factor = cfg.n_starts * cfg.iterations
        bench.timings["multi_start.torch_loop"] = Timing(
            factor * loop.median_s, factor * loop.q25_s, factor * loop.q75_s, loop.n
        )
    errors = work().errors
    finite = errors[np.isfinite(errors)]
    levels = {"min": 0.0, "q25": 0.25, "median": 0.5, "q75": 0.75, "max": 1.0}
    counts = {"n_starts": float(len(errors)), "n_dropped": float(len(errors) - len(finite))}
    return counts | {name: float(np.quantile(finite, q)) for name, q in levels.items()}


def _paper(bench: _Bench) -> None:
    """75 minutes of four IMUs at 500 Hz: networks of all three axes, coupled."""
    cfg = bench.cfg
    n_recordings = 15 * 4
    v, _ = gait_like(cfg.n_rollout_samples)
    axes = np.array([2.0, 0.3, 0.4])
    rates = torch.from_numpy(v[:, None] * axes).expand(n_recordings, -1, -1)
    scale = torch.ones(3, dtype=torch.float64)
    weights = torch.from_numpy(bench.weights)

    def work() -> None:
        for part in rates.split(20):
            coupled_closed_loop(
                weights, part, rate_scale=2.0 * scale, angle_scale=0.4 * scale,
                structure=STRUCTURE,
            )  # fmt: skip

    bench.time("coupled_75_minutes_4_imus.narx", work, slow=True)


def _streams(bench: _Bench) -> None:
    for name, (work, factor) in streams.works(bench.cfg.peers).items():
        bench.time(name, work, factor=factor)


def _stream_ratios(bench: _Bench) -> dict[str, float | None]:
    """Time of a sample within a whole recording, and of VQF's update, relative to the stream's."""
    found = {}
    for kind in ("stream_tracked", "stream"):
        for way in ("one_sensor", "in_step"):
            own = f"{kind}.{way}"
            found[f"{kind}_{way}_vs_recording"] = bench.ratio(f"{kind}.recording", own)
            found[f"{kind}_{way}_vs_vqf"] = bench.ratio("stream.vqf", own)
    return found


def _ratios(bench: _Bench) -> dict[str, float | None]:
    own = "closed_loop_jacobian.narx"
    n = f"rollout_{bench.cfg.n_channels}"
    scans = [bench.ratio(f"closed_loop_jacobian.jax_scan_unroll_{u}", own) for u in (1, 8)]
    loops = [
        bench.ratio(f"closed_loop_jacobian.torch_{kind}_loop", own)
        for kind in ("scripted", "eager")
    ]

    def least(ratios: list[float | None]) -> float | None:
        known = [ratio for ratio in ratios if ratio is not None]
        return min(known) if known else None

    return {
        "closed_loop_jacobian_vs_torch_loop": least(loops),
        "closed_loop_jacobian_vs_jax_scan": least(scans),
        "closed_loop_jacobian_vs_pyrenn": bench.ratio("closed_loop_jacobian.pyrenn", own),
        "closed_loop_jacobian_vs_c": bench.ratio("closed_loop_jacobian.c", own),
        "open_loop_lm_vs_scipy": bench.ratio("open_loop_lm.scipy", "open_loop_lm.narx"),
        "open_loop_lm_vs_torch_levenberg_marquardt": bench.ratio(
            "open_loop_lm.torch_levenberg_marquardt", "open_loop_lm.narx"
        ),
        "open_loop_lm_vs_optimistix": bench.ratio("open_loop_lm.optimistix", "open_loop_lm.narx"),
        "rollout_1_vs_torchscript": bench.ratio("rollout_1.torchscript", "rollout_1.narx"),
        "rollout_1_vs_c": bench.ratio("rollout_1.c", "rollout_1.narx"),
        "rollout_180_vs_torchscript": bench.ratio(f"{n}.torchscript", f"{n}.narx"),
        "rollout_180_vs_c": bench.ratio(f"{n}.c", f"{n}.narx_1_thread"),
        **_stream_ratios(bench),
        "multi_start_vs_torch_loop": bench.ratio("multi_start.torch_loop", "multi_start.narx"),
    }


def _speed(cfg: DictConfig) -> None:
    """Run everything, print the table, write speed.json."""
    seed_everything(cfg.seed)
    print("OPENBLAS_CORETYPE and OPENBLAS_L2_SIZE are unset; medians follow", flush=True)
    bench = _Bench(cfg)
    with tempfile.TemporaryDirectory() as folder:
        c = None
        if cfg.peers and CompiledC.available():
            c = CompiledC(Path(folder))
        _closed_loop_jacobian(bench, c)
        race = _open_loop_training(bench)
        errors = _rollout(bench, c)
    spread = _multi_start(bench)
    _paper(bench)
    _streams(bench)
    ratios = _ratios(bench)
    report: dict[str, Any] = dict(ratios)
    report["timings"] = {name: vars(timing) for name, timing in bench.timings.items()}
    report["race_to_the_same_cost"] = race
    report["difference_to_exact_tanh"] = errors
    report["multi_start_spread"] = spread
    if cfg.first_use:
        report["compilation"] = first_use()
    report["environment"] = environment(cfg.seed, {})
    write_json(report, run_directory() / "speed.json")
    print("\npeer / project (above 1: the project is faster)")
    for name, ratio in ratios.items():
        print(f"  {name:<48} {'-' if ratio is None else f'{ratio:10.3g}'}")
    for name in ("race_to_the_same_cost", "difference_to_exact_tanh", "compilation"):
        print(f"{name}: {report.get(name)}")
    print(run_directory() / "speed.json")


main = command("speed")(_speed)

if __name__ == "__main__":
    main()
