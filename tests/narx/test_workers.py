"""Threads, forks and worker processes give the result of a single call, and terminate."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from narx.inference.pretrained import load_or_pretrained

pytestmark = pytest.mark.concurrency

ROOT = Path(__file__).resolve().parents[2]
# a small compiled function: stride frequency sample by sample
FOLLOW = """
import hashlib, numpy as np
from narx.gait.stride_frequency import StrideFrequencyTracker
rate = 2.0 * np.cos(np.arange(3000) * 0.05)
print(hashlib.sha256(StrideFrequencyTracker().follow(rate, 100.0)).hexdigest())
"""
# the network in child processes of one that has used it
WORKERS = """
import sys
import numpy as np
import torch
from narx.inference.pretrained import load_or_pretrained
from narx.method import SegmentSignals

METHOD = load_or_pretrained(None).method()

def angles(seed):
    rates = np.random.default_rng(seed).normal(size=(2000, 3))
    return METHOD.estimate(SegmentSignals("thigh", 100.0, rates, rates, np.zeros(3)))

class Walks(torch.utils.data.Dataset):
    def __len__(self):
        return 6
    def __getitem__(self, k):
        return angles(k)

def in_loader():
    return list(torch.utils.data.DataLoader(Walks(), batch_size=None, num_workers=2))

def in_loky():
    import joblib
    return joblib.Parallel(n_jobs=2, backend="loky")(joblib.delayed(angles)(k) for k in range(6))

def in_fork():
    import multiprocessing
    with multiprocessing.get_context("fork").Pool(2) as pool:
        return pool.map(angles, range(6))

if __name__ == "__main__":
    torch.set_num_threads(2)
    alone = [angles(k) for k in range(6)]
    together = globals()[sys.argv[1]]()
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(alone, together)), sys.argv
    print("same")
"""


def run(script, *arguments, **environment):
    answer = subprocess.run(
        [sys.executable, "-W", "ignore", *script, *arguments], capture_output=True, text=True,
        cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT), **environment}, timeout=300,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    return answer.stdout.strip()


def test_eight_threads_of_a_pool(motion):
    method = load_or_pretrained(None).method()
    signals = [motion("walking", duration_s=10.0 + k).signals for k in range(16)]
    alone = [method.estimate(one) for one in signals]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(method.estimate, signals))
    for one, other in zip(alone, together, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["in_loader", "in_loky", "in_fork"])
def test_worker_processes_of_a_process_that_has_used_the_network(workers, tmp_path):
    if workers == "in_loky":
        pytest.importorskip("joblib")
    script = tmp_path / "workers.py"
    script.write_text(WORKERS)
    assert run([str(script)], workers) == "same"


@pytest.mark.slow
def test_two_first_uses_with_one_empty_cache(tmp_path):
    expected = run(["-c", FOLLOW])
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path / "c")}
    both = [
        subprocess.Popen(
            [sys.executable, "-c", FOLLOW], stdout=subprocess.PIPE, text=True, cwd=ROOT,
            env=environment,
        )
        for _ in range(2)
    ]  # fmt: skip
    assert [process.communicate(timeout=300)[0].strip() for process in both] == [expected] * 2
    assert list(tmp_path.rglob("*.nbc"))
    assert run(["-c", FOLLOW], NUMBA_CACHE_DIR=str(tmp_path / "c")) == expected


def test_without_a_home(tmp_path):
    expected = run(["-c", FOLLOW])
    nowhere = {"HOME": str(tmp_path / "none"), "XDG_CACHE_HOME": "", "PYTHONDONTWRITEBYTECODE": "1"}
    assert run(["-c", FOLLOW], **nowhere) == expected
