"""Measuring the time and memory of a run."""

import subprocess
import sys
import threading
import time

import pytest

from narx.evaluation.workload import Workload, peak_memory_mib


def work(seconds):
    begun = time.thread_time()
    while time.thread_time() - begun < seconds:
        pass


def work_elsewhere(seconds):
    other = threading.Thread(target=work, args=(seconds,))
    other.start()
    other.join()


def test_time_is_counted_by_method_even_if_it_fails():
    workload = Workload()
    with workload.of_method("a", 1000):
        work(0.02)
    with pytest.raises(ValueError, match="gives up"), workload.of_method("b", 0):
        raise ValueError("gives up")
    first = workload.methods_s["a"]
    work_elsewhere(0.1)
    with workload.of_method("a", 500):
        work(0.01)
        time.sleep(0.1)  # not its work
        work_elsewhere(0.1)  # nor is this
    assert first + 0.1 > workload.methods_s["a"] >= first + 0.01 >= 0.03
    report = workload.report()
    assert list(report["methods_s"]) == ["a", "b"]
    assert report["us_per_sample"] == {"a": pytest.approx(workload.methods_s["a"] * 1e6 / 1500)}
    assert report["all_methods_s"] == sum(workload.methods_s.values())
    assert report["run_s"] >= report["all_methods_s"]


@pytest.mark.skipif(peak_memory_mib() is None, reason="the system does not tell")
def test_peak_memory_sees_a_large_array():
    """Run in a separate process, since earlier tests may have raised this one's peak memory."""
    program = (
        "import numpy as np; from narx.evaluation.workload import peak_memory_mib as peak;"
        "before = peak(); array = np.ones(300 * 2**17); print(peak() - before)"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert 200.0 < float(run.stdout) < 310.0
