"""The store returns what was saved bit for bit, and only if nothing has changed since."""

import ast
import os
import pickle
import threading
from pathlib import Path

import numpy as np
import pytest

import narx
from narx.datasets import SimulatedGait
from narx.datasets.prepared import ROOMS, PreparedSource, TrialStore

NAMES = ("S1", "normal", "1")


class CountingGait(SimulatedGait):
    """Counts the simulations."""

    count = 0

    def _load(self, subject, condition, trial):
        CountingGait.count += 1
        return super()._load(subject, condition, trial)


def gait(store, options="a"):
    source = CountingGait(
        subjects=["S1"], conditions=["normal"], treadmill_duration_s=30.0, sampling_rate_hz=100.0
    )
    return PreparedSource(source, options, store)


@pytest.fixture
def store(tmp_path):
    CountingGait.count = 0
    return TrialStore(tmp_path, 1e9)


def test_the_second_time_nothing_is_simulated_and_every_bit_is_the_same(store):
    first = gait(store).load_calibrated(*NAMES)
    second = gait(store).load_calibrated(*NAMES)
    assert CountingGait.count == 1
    assert pickle.dumps(first) == pickle.dumps(second)
    fresh = gait(store)._source.load_calibrated(*NAMES)
    for name, segment in fresh[1].items():
        stored = second[1][name]
        assert np.array_equal(segment.signals.axis_rates_rad_s, stored.signals.axis_rates_rad_s)
        assert np.array_equal(
            segment.reference_angles_rad, stored.reference_angles_rad, equal_nan=True
        )


def test_other_options_or_another_calibration_are_made_anew(store):
    gait(store).load_calibrated(*NAMES)
    gait(store, "b").load_calibrated(*NAMES)
    gait(store).load_calibrated(*NAMES, "functional")
    assert CountingGait.count == 3


def test_a_damaged_file_is_made_anew(store, tmp_path):
    gait(store).load_calibrated(*NAMES)
    (path,) = tmp_path.glob("*.pickle")
    path.write_bytes(path.read_bytes()[:1000])
    gait(store).load_calibrated(*NAMES)
    gait(store).load_calibrated(*NAMES)
    assert CountingGait.count == 2


def test_the_least_recently_used_is_deleted_first(tmp_path):
    store = TrialStore(tmp_path, 2500)
    for age, key in enumerate("abc"):
        store.get(key, lambda: bytes(900))
        os.utime(tmp_path / f"{key}.pickle", (1000 + age, 1000 + age))
    store.get("a", lambda: bytes(900))  # now the most recently used
    store.get("d", lambda: bytes(900))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.pickle", "d.pickle"]


@pytest.mark.concurrency
def test_jobs_that_want_the_same_wait_for_the_first(tmp_path):
    store = TrialStore(tmp_path, 1e9)
    made, results = [], []
    begun = threading.Barrier(4)

    def make():
        made.append(1)
        threading.Event().wait(0.2)
        return 7

    def job():
        begun.wait()
        results.append(store.get("k", make))

    threads = [threading.Thread(target=job) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [7] * 4
    assert len(made) == 1


def test_a_store_that_cannot_be_written_to_still_gives_the_trial(tmp_path, monkeypatch):
    monkeypatch.setattr(pickle, "dump", lambda *_, **__: (_ for _ in ()).throw(OSError("full")))
    assert TrialStore(tmp_path, 1e9).get("k", lambda: 7) == 7
    assert list(tmp_path.iterdir()) == []


def test_the_rooms_that_prepare_trials_import_from_no_other():
    package = Path(narx.__file__).parent
    files = [package / room for room in ROOMS]
    for path in [file for top in files for file in ([top] if top.is_file() else top.rglob("*.py"))]:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("narx."):
                room = node.module.split(".")[1]
                assert room in ROOMS or f"{room}.py" in ROOMS, f"{path} imports {node.module}"
