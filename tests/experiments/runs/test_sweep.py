"""A failing job does not stop the other jobs of its sweep, with any launcher."""

import logging
import os
import signal
import sys
from pathlib import Path

import pytest
from hydra.core.global_hydra import GlobalHydra

from narx.errors import UserError
from narx.experiments.command import command, run_directory

pytestmark = pytest.mark.slow

LAUNCHERS = {
    "basic": [],
    "joblib": ["hydra/launcher=joblib", "hydra.launcher.n_jobs=2"],
    "submitit_local": ["hydra/launcher=submitit_local"],
    "optuna": ["hydra/sweeper=optuna", "hydra.sweeper.n_trials=12", "hydra.sweeper.n_jobs=1"],
}


def train(cfg):
    """Stand in for a training: leaves a file, fails where it cannot work."""
    if cfg.model.hidden == 0:
        raise UserError("model.hidden is 0, expected a whole number from 1 to 64")
    if cfg.model.hidden == 9:
        raise KeyError("a fault of the program,\nin two lines")
    if cfg.model.hidden == 10:
        sys.exit(3)
    if cfg.model.hidden == 11:
        os.kill(os.getpid(), signal.SIGKILL)
    (run_directory() / "checkpoint.txt").write_text(f"{cfg.model.hidden} {cfg.seed}")
    return float(cfg.model.hidden)


@pytest.fixture
def launch(tmp_path, monkeypatch, capfd):
    def run(*overrides, function=train):
        monkeypatch.chdir(tmp_path)
        # Hydra and Optuna log on to the streams of the test before
        monkeypatch.setattr(logging, "raiseExceptions", False)
        monkeypatch.setattr(sys, "argv", ["narx-train", "-m", *overrides])
        capfd.readouterr()
        status = 0
        try:
            command("train")(function)()
        except SystemExit as stop:
            status = stop.code
        finally:
            GlobalHydra.instance().clear()
        printed = capfd.readouterr()
        return status, printed.out, printed.err

    return run


def checkpoints(folder):
    return sorted(path.read_text() for path in Path(folder).glob("*/checkpoint.txt"))


@pytest.fixture
def by_value():
    """Hand the stand-in to other processes by value: they cannot import the tests."""
    cloudpickle = pytest.importorskip("cloudpickle")  # of joblib and of submitit
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    yield
    cloudpickle.unregister_pickle_by_value(sys.modules[__name__])


@pytest.mark.usefixtures("by_value")
@pytest.mark.parametrize("launcher", LAUNCHERS)
def test_all_other_jobs_of_a_sweep_finish(launch, launcher):
    pytest.importorskip(
        {"joblib": "joblib", "submitit_local": "submitit", "optuna": "optuna"}.get(launcher, "sys")
    )
    status, _, err = launch("model.hidden=2,0,3", "hydra.sweep.dir=SW", *LAUNCHERS[launcher])
    assert status == 2
    assert checkpoints("SW") == ["2 0", "3 0"]
    errors = [line for line in err.splitlines() if line.startswith("error: ")]
    assert errors
    for line in errors:  # Optuna may try the same again
        assert "(model.hidden=0): model.hidden is 0, expected a whole number from 1 to 64" in line
    assert "Traceback" not in err
    if launcher != "optuna":
        assert len(errors) == 1
        assert errors[0].startswith("error: job 1 ")


def test_every_batch_runs(launch):
    status, _, err = launch(
        "model.hidden=0,2,3", "hydra.sweep.dir=SW", "hydra.sweeper.max_batch_size=1"
    )
    assert status == 2
    assert checkpoints("SW") == ["2 0", "3 0"]
    assert err.count("error: ") == 1


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        (["seed=range(0,1e9)"], "seed=range(0,1e9): makes 1e+09 jobs, expected at most 10000"),
        (["seed=range(0,1000)", "model.hidden=choice(2,3)", "optimizer.cost_deg2=range(9,0,-0.1)"],
         "optimizer.cost_deg2=range(9,0,-0.1): makes 180000 jobs"),
        (["seed=range(0,5,0)"], "seed=range(0,5,0): makes inf jobs"),
        (["seed=range(5,5)"], "seed=range(5,5): no value to run with"),
        (["seed=glob(*)"], "seed=glob(*): no value to run with"),
        (["optimizer=glob(x*)"], "optimizer=glob(x*): no value to run with"),
    ],
)  # fmt: skip
def test_a_sweep_of_no_or_countless_jobs_does_not_begin(launch, values, problem):
    status, out, err = launch(*values, "hydra.sweep.dir=SW")
    assert status == 2
    assert err.startswith(f"error: {problem}")
    assert len(err.splitlines()) == 1
    assert "Launching" not in out
    assert not Path("SW").exists()


def test_overrides_may_stand_on_both_sides_of_the_flag(launch, monkeypatch, tmp_path):
    def at_the_end(cfg):
        (run_directory() / "checkpoint.txt").write_text(f"{cfg.model.hidden} {cfg.seed}")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["narx-train", "model.hidden=2,3", "--multirun", "seed=1",
                                      "hydra.sweep.dir=SW"])  # fmt: skip
    command("train")(at_the_end)()
    GlobalHydra.instance().clear()
    assert checkpoints("SW") == ["2 1", "3 1"]


def test_a_fault_of_the_program_has_its_traceback_in_the_run(launch):
    status, _, err = launch("model.hidden=9,0,2", "hydra.sweep.dir=SW")
    assert status == 1
    assert checkpoints("SW") == ["2 0"]
    (line, other) = [line for line in err.splitlines() if line.startswith("error: ")]
    assert r"KeyError: 'a fault of the program,\nin two lines'" in line
    assert "model.hidden is 0" in other
    (text,) = Path("SW").glob("model.hidden=9-*/traceback.txt")
    assert "KeyError" in text.read_text()


@pytest.mark.parametrize("values", ["10,2", "2,10"])
def test_a_job_that_exits_does_not_end_the_sweep(launch, values):
    status, _, err = launch(f"model.hidden={values}", "hydra.sweep.dir=SW")
    assert status == 1
    assert checkpoints("SW") == ["2 0"]
    assert "(model.hidden=10): RuntimeError: the job has called sys.exit(3)" in err
    assert len(err.splitlines()) == 1


@pytest.mark.concurrency
@pytest.mark.usefixtures("by_value")
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_killed_worker_is_named_and_the_others_run_when_the_command_is_repeated(launch, tmp_path):
    pytest.importorskip("joblib")
    sweep = tmp_path / "sweep"  # absolute: joblib may use the workers of the test before
    command_line = ("model.hidden=11,2,3,4", f"hydra.sweep.dir={sweep}", *LAUNCHERS["joblib"])
    status, _, err = launch(*command_line)
    assert status == 1, err
    assert f"error: {sweep}/model.hidden=11-" in err
    for line in err.splitlines():  # the process of another job may have been ended, too
        assert "its process has ended without a result" in line

    def with_enough_memory(cfg):
        (run_directory() / "checkpoint.txt").write_text(f"{cfg.model.hidden} {cfg.seed}")

    assert launch(*command_line, function=with_enough_memory)[0] == 0
    assert checkpoints(sweep) == ["11 0", "2 0", "3 0", "4 0"]


def test_a_search_in_which_every_trial_fails_prints_only_one_line_each(launch):
    pytest.importorskip("optuna")
    status, _, err = launch("model.hidden=0", "seed=range(0,4)", *LAUNCHERS["optuna"],
                            "hydra.sweeper.n_trials=2")  # fmt: skip
    assert status == 2
    assert err.count("error: job ") == 2
    assert "Traceback" not in err


def test_a_search_counts_the_trials_of_earlier_launches(launch):
    optuna = pytest.importorskip("optuna")
    search = ("model.hidden=range(1,8)", "hydra/sweeper=optuna", "hydra.sweep.dir=SW")
    assert launch(*search, "hydra.sweeper.n_trials=4")[0] == 0
    assert launch(*search, "hydra.sweeper.n_trials=6")[0] == 0
    study = optuna.load_study(study_name=None, storage="sqlite:///SW/optuna.db")
    assert len(study.trials) == 6
    assert study.best_value == min(float(text.split()[0]) for text in checkpoints("SW"))


@pytest.mark.parametrize("other", ["seed=5", "model.hidden=range(2,8)"])
def test_another_search_in_the_same_folder_has_a_study_of_its_own(launch, other):
    optuna = pytest.importorskip("optuna")
    search = ("model.hidden=range(1,8)", "hydra/sweeper=optuna", "hydra.sweep.dir=SW",
              "hydra.sweeper.n_trials=2")  # fmt: skip
    assert launch(*search)[0] == 0
    assert launch(*search, other)[0] == 0
    studies = optuna.get_all_study_summaries("sqlite:///SW/optuna.db")
    assert [study.n_trials for study in studies] == [2, 2]


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("hydra.sweeper.n_trials=0", "n_trials is 0, expected a whole number of at least 1"),
        ("hydra.sweeper.n_jobs=-1", "n_jobs is -1, expected a whole number of at least 1"),
        ("hydra.sweeper.direction=[minimize,minimize]", "direction has 2 for 1 objectives"),
        ("objectives=[held_back_error_deg,n_weights]", "direction has 1 for 2 objectives"),
        ("hydra.sweeper.direction=smallest", "direction is 'smallest', expected"),
        ("hydra.sweeper.storage=nonsense", "storage is 'nonsense': "),
        ("model.hidden=3", "nothing varies"),
    ],
)
def test_a_search_that_cannot_end_well_is_refused_before_its_jobs(launch, tmp_path, override, said):
    pytest.importorskip("optuna")
    swept = [] if override.startswith("model") else ["model.hidden=range(1,8)"]
    status, _, err = launch("hydra/sweeper=optuna", *swept, override)
    assert status == 2
    (line,) = [line for line in err.splitlines() if line.startswith("error: ")]
    assert said in line
    assert list(tmp_path.iterdir()) == []


def test_a_study_of_other_objectives_is_refused(launch):
    pytest.importorskip("optuna")
    search = ("model.hidden=range(1,8)", "hydra/sweeper=optuna", "hydra.sweep.dir=SW",
              "hydra.sweeper.n_trials=1", "hydra.sweeper.study_name=mine")  # fmt: skip
    assert launch(*search)[0] == 0
    status, _, err = launch(*search, "hydra.sweeper.direction=[minimize,minimize]",
                            "objectives=[held_back_error_deg,n_weights]")  # fmt: skip
    assert status == 2
    assert "study_name is 'mine', a study of 1 objectives" in err


def test_a_repeated_sweep_runs_missing_jobs_and_keeps_finished_ones(launch):
    assert launch("seed=0,1", "hydra.sweep.dir=SW")[0] == 0
    before = {p: (p.read_bytes(), p.stat().st_mtime_ns) for p in Path("SW").glob("seed*/**/*")
              if p.is_file()}  # fmt: skip
    status, out, _ = launch("seed=0,1,2", "hydra.sweep.dir=SW")
    assert status == 0
    assert out.count("already finished") == 2
    assert checkpoints("SW") == ["3 0", "3 1", "3 2"]
    assert before
    for path, (content, changed_ns) in before.items():
        assert path.read_bytes() == content
        assert path.stat().st_mtime_ns == changed_ns


def test_a_sweep_finds_its_folder_by_its_command(launch):
    assert launch("seed=0,1")[0] == 0
    assert launch("seed=0,2")[0] == 0
    status, out, _ = launch("seed=0,1", "hydra.job.chdir=false")
    assert status == 0
    assert out.count("already finished") == 2
    assert len(list(Path("multirun").glob("*/*"))) == 2


def test_a_sweep_that_is_refused_before_its_jobs_leaves_nothing(launch, tmp_path):
    misspelt = "optimizer=lbfgs,nonsense"
    status, _, err = launch(misspelt)
    assert status == 2
    assert "nonsense" in err
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "mine").mkdir()
    assert launch(misspelt, "hydra.sweep.dir=mine/of/SW")[0] == 2
    assert list(tmp_path.rglob("*")) == [tmp_path / "mine"]
    assert launch("seed=0", "hydra.sweep.dir=mine")[0] == 0
    assert launch(misspelt, "hydra.sweep.dir=mine")[0] == 2
    assert checkpoints("mine") == ["3 0"]


def test_ctrl_c_keeps_finished_jobs(launch):
    def train_until_stopped(cfg):
        if cfg.seed == 1:
            raise KeyboardInterrupt
        return train(cfg)

    status, _, err = launch("seed=0,1,2", "hydra.sweep.dir=SW", function=train_until_stopped)
    assert status == 130
    assert err.strip().splitlines() == [
        "interrupted: finished work is kept; repeat the command to run the unfinished jobs"
    ]
    assert checkpoints("SW") == ["3 0"]
    assert launch("seed=0,1,2", "hydra.sweep.dir=SW")[0] == 0
    assert checkpoints("SW") == ["3 0", "3 1", "3 2"]


def test_a_search_with_two_objectives_finds_the_pareto_front(launch):
    optuna = pytest.importorskip("optuna")

    def two(cfg):
        if cfg.model.hidden == 7:
            raise UserError("model.hidden is 7, expected less")
        return [1.0 / cfg.model.hidden, float(cfg.model.hidden)]

    search = (
        "model.hidden=range(1,8)", "hydra/sweeper=optuna", "hydra.sweep.dir=SW",
        "hydra.sweeper.n_jobs=1",
        "hydra.sweeper.direction=[minimize,minimize]", "objectives=[held_back_error_deg,n_weights]",
    )  # fmt: skip
    status, _, err = launch(*search, "hydra.sweeper.n_trials=12", function=two)
    assert status == (2 if "error: job" in err else 0)
    assert "Traceback" not in err
    status, _, _ = launch(*search, "hydra.sweeper.n_trials=14", function=two)
    assert status in (0, 2)
    study = optuna.load_study(study_name=None, storage="sqlite:///SW/optuna.db")
    states = [trial.state for trial in study.trials]
    assert states.count(optuna.trial.TrialState.COMPLETE) >= 12
    best = {trial.params["model.hidden"]: trial.values for trial in study.best_trials}
    # neither has both fewer neurons and a smaller error: no trial dominates another
    assert len(best) > 1
    assert all(values == [1.0 / hidden, float(hidden)] for hidden, values in best.items())
