"""A run's folder belongs to one process and one run, and is immutable once finished."""

import json
import subprocess
import sys
import threading
import time

import pytest
from omegaconf import OmegaConf

from narx.errors import UserError
from narx.experiments.runs import folder as folders
from narx.experiments.runs.folder import claimed, read_record
from narx.files import files_sha256

CFG = OmegaConf.create({"seed": 0, "model": {"hidden": 3}, "data_root": "/a"})


@pytest.fixture(autouse=True)
def _without_hydra(monkeypatch):
    def write(folder, cfg):
        (folder / ".hydra").mkdir(exist_ok=True)
        OmegaConf.save(cfg, folder / ".hydra" / "config.yaml")

    monkeypatch.setattr(folders, "_write_configuration", write)


def finish(path, cfg=CFG, data=None):
    with claimed(path, cfg, data or {}) as run:
        if not run.finished:
            run.end("finished", value=1.5)
        return run


def test_a_run_is_done_once(tmp_path):
    assert finish(tmp_path / "run").record["value"] == 1.5
    with claimed(tmp_path / "run", CFG, {}) as run:
        assert run.finished
        assert run.record["value"] == 1.5


def test_identity_depends_on_the_data_and_not_on_their_location(tmp_path):
    finish(tmp_path / "run", data={"walks": "a"})
    moved = OmegaConf.merge(CFG, {"data_root": "/b"})
    assert finish(tmp_path / "run", moved, {"walks": "a"}).finished
    with pytest.raises(UserError, match="finished run on other data"):
        finish(tmp_path / "run", CFG, {"walks": "b"})


def test_another_configuration_is_refused_with_the_difference(tmp_path):
    finish(tmp_path / "run")
    other = OmegaConf.merge(CFG, {"model": {"hidden": 4}})
    with pytest.raises(UserError, match=r"model\.hidden was 3, now 4"):
        finish(tmp_path / "run", other)


def test_another_version_of_the_code_is_refused(tmp_path, monkeypatch):
    finish(tmp_path / "run")
    for module in (folders, sys.modules["narx.experiments.runs.identity"]):
        monkeypatch.setattr(module, "code_digest", lambda: "other")
    with pytest.raises(UserError, match="another version of the code"):
        finish(tmp_path / "run")


@pytest.mark.parametrize(
    ("error", "state"),
    [(UserError("no"), "failed"), (KeyError("no"), "failed"), (KeyboardInterrupt(), "interrupted")],
)
def test_how_a_run_ends_is_written_down_and_it_can_be_done_again(tmp_path, error, state):
    with pytest.raises(type(error)), claimed(tmp_path, CFG, {}):
        raise error
    record = read_record(tmp_path)
    assert record is not None
    assert record["state"] == state
    assert (tmp_path / "traceback.txt").exists() == isinstance(error, KeyError)
    finish(tmp_path)
    assert not (tmp_path / ".lock").exists()


@pytest.mark.concurrency
def test_two_processes_do_not_work_in_one_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(folders, "_PATIENCE_S", 0.0)
    with claimed(tmp_path, CFG, {}):
        script = (
            "import sys; from filelock import FileLock, Timeout\n"
            "try: FileLock(sys.argv[1]).acquire(timeout=0)\n"
            "except Timeout: print('taken')"
        )
        answer = subprocess.run(
            [sys.executable, "-c", script, str(tmp_path / ".lock")], capture_output=True, text=True
        )
        assert answer.stdout.strip() == "taken"
        with pytest.raises(UserError, match="another process is using this folder"):
            finish(tmp_path)


@pytest.mark.concurrency
def test_a_run_finished_meanwhile_by_another_process_is_used(tmp_path):
    claimed_first, waited = threading.Event(), []

    def first():
        with claimed(tmp_path, CFG, {}) as run:
            claimed_first.set()
            time.sleep(0.3)
            run.end("finished", value=2.5)

    thread = threading.Thread(target=first)
    thread.start()
    claimed_first.wait()
    with claimed(tmp_path, CFG, {}) as run:
        waited.append((run.finished, run.record.get("value")))
    thread.join()
    assert waited == [(True, 2.5)]


def test_a_record_that_was_tampered_with_is_named(tmp_path):
    (tmp_path / "run.json").write_text(json.dumps({"state": "finished"}))
    with pytest.raises(UserError, match=r"run\.json: not the record of a run"):
        finish(tmp_path)


def test_the_digest_of_a_folder_sees_names_and_contents(tmp_path):
    (tmp_path / "a.txt").write_text("1")

    def digest():
        return files_sha256(tmp_path, sorted(tmp_path.iterdir()))

    first = digest()
    assert digest() == first
    (tmp_path / "a.txt").rename(tmp_path / "b.txt")
    second = digest()
    (tmp_path / "b.txt").write_text("22")
    assert len({first, second, digest()}) == 3
