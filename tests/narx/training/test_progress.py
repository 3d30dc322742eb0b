"""An interrupted training resumes where it stopped, with bit-identical results."""

import subprocess
import sys

import numpy as np
import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from narx import Trainer
from narx.training import Adam, Lbfgs, LevenbergMarquardt, progress
from narx.windows import from_arrays

OPTIMIZERS = {
    # more starts than are trained at once
    "levenberg_marquardt": LevenbergMarquardt(restarts=18, iterations=12),
    "bayesian": LevenbergMarquardt(restarts=2, iterations=12, bayesian=True),
    "lbfgs": Lbfgs(restarts=3, iterations=8),
    "adam": Adam(restarts=3, iterations=8),
}


class CutOff(Exception):
    """As if the process had been killed."""


def swing():
    time_s = np.arange(0, 12, 0.02)
    angles = 0.4 * np.sin(2 * np.pi * 0.9 * time_s)[:, None] * [1.0, 0.2, 0.0]
    return from_arrays(np.gradient(angles, 0.02, axis=0), angles, 50.0)


def trained(optimizer, folder, cut_after=None):
    """Train and return the network and all that was logged."""
    logged = []

    def log(iteration, numbers):
        if cut_after is not None and len(logged) == cut_after:
            raise CutOff
        logged.append((iteration, numbers))

    network = Trainer(optimizer=optimizer, seed=1, progress_folder=folder).fit(swing(), log=log)
    return network, logged


@pytest.mark.concurrency
@pytest.mark.parametrize("name", OPTIMIZERS)
def test_it_ends_with_the_same_network_and_the_same_log(monkeypatch, tmp_path, name):
    monkeypatch.setattr(progress, "INTERVAL_S", 0.0)
    optimizer = OPTIMIZERS[name]
    undisturbed, logged = trained(optimizer, None)
    for cut_after in (1, len(logged) // 3, len(logged) * 2 // 3, len(logged) - 1):
        folder = tmp_path / str(cut_after)
        with pytest.raises(CutOff):
            trained(optimizer, folder, cut_after)
        # ignore the temporary file that the thread of the other group of starts may be writing
        (state,) = folder.glob("[!.]*.pt")
        assert torch.load(state, weights_only=True)
        resumed, again = trained(optimizer, folder)
        assert torch.equal(resumed.model.weights, undisturbed.model.weights)
        assert str(resumed.history) == str(undisturbed.history)
        assert sorted(map(str, again)) == sorted(map(str, logged))


@pytest.mark.parametrize("name", OPTIMIZERS)
def test_work_before_an_interruption_is_not_repeated(monkeypatch, tmp_path, name):
    monkeypatch.setattr(progress, "INTERVAL_S", 0.0)
    optimizer, n_iterations = OPTIMIZERS[name], len(trained(OPTIMIZERS[name], None)[1])
    with pytest.raises(CutOff):
        trained(optimizer, tmp_path, cut_after=n_iterations - 3)
    kept = []
    monkeypatch.setattr(progress.Progress, "keep", lambda self, part, state: kept.append(part))
    trained(optimizer, tmp_path)
    assert len(kept) <= 5


def test_another_training_does_not_go_on_from_there(monkeypatch, tmp_path):
    monkeypatch.setattr(progress, "INTERVAL_S", 0.0)
    with pytest.raises(CutOff):
        trained(OPTIMIZERS["lbfgs"], tmp_path, cut_after=9)
    other = Lbfgs(restarts=3, iterations=9)
    assert torch.equal(
        trained(other, tmp_path)[0].model.weights, trained(other, None)[0].model.weights
    )


def test_a_damaged_state_costs_only_time(monkeypatch, tmp_path):
    monkeypatch.setattr(progress, "INTERVAL_S", 0.0)
    with pytest.raises(CutOff):
        trained(OPTIMIZERS["adam"], tmp_path, cut_after=9)
    (state,) = tmp_path.glob("*.pt")
    state.write_bytes(state.read_bytes()[:1000])
    assert torch.equal(
        trained(OPTIMIZERS["adam"], tmp_path)[0].model.weights,
        trained(OPTIMIZERS["adam"], None)[0].model.weights,
    )


def test_a_short_training_writes_nothing(tmp_path):
    trained(OPTIMIZERS["lbfgs"], tmp_path / "last")
    assert not (tmp_path / "last").exists()


def test_an_optimizer_that_takes_no_progress_begins_anew(tmp_path):
    class Own:
        def fit(self, model, training, validation, objective, rng, log, start=None):
            return Lbfgs(restarts=1, iterations=3).fit(
                model, training, validation, objective, rng, log
            )

    assert trained(Own(), tmp_path / "last")[0].model.weights.abs().sum() > 0


KILLED = """
import os, signal, sys
from hydra.core.hydra_config import HydraConfig
from narx.training import progress

progress.INTERVAL_S = 0.0
victim, kept, n = sys.argv.pop(1), progress.Progress.keep, 0

def keep(self, part, state):
    global n
    kept(self, part, state)
    n += victim in HydraConfig.get().job.override_dirname
    if n == 5:
        os.kill(os.getpid(), signal.SIGKILL)

progress.Progress.keep = keep
from narx.experiments.train import main
main()
"""
LEFT = ("checkpoint.pt", "results.csv", "metrics.json", "training.json", "angles.csv")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_sweep_killed_within_its_trainings_continues(tmp_path):
    optimizers = ("levenberg_marquardt", "lbfgs", "adam")

    def run(folder, victim):
        call = [sys.executable, "-c", KILLED, victim, "-m", "debug=tiny"]
        call += [f"optimizer={','.join(optimizers)}", f"hydra.sweep.dir={folder}"]
        return subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=False)

    undisturbed = run("undisturbed", "none")
    assert undisturbed.returncode == 0, undisturbed.stderr
    for optimizer in optimizers:
        assert run("disturbed", optimizer).returncode == -9
        (state,) = tmp_path.glob(f"disturbed/optimizer={optimizer}*/last/*.pt")
        assert torch.load(state, weights_only=True)
    assert run("disturbed", "none").returncode == 0
    runs = list(tmp_path.glob("undisturbed/optimizer=*"))
    assert len(runs) == 3
    for left in runs:
        resumed = tmp_path / "disturbed" / left.name
        for name in LEFT:
            assert (left / name).read_bytes() == (resumed / name).read_bytes()
        (one,), (other,) = (list(run.glob("tensorboard/events*")) for run in (left, resumed))
        assert scalars(one) == scalars(other)
        assert not (resumed / "last").exists()


def scalars(path):
    events = EventAccumulator(str(path)).Reload()
    return {tag: [(event.step, event.value) for event in events.Scalars(tag)]
            for tag in events.Tags()["scalars"]}  # fmt: skip
