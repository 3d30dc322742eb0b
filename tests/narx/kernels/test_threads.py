"""Threads over sequences."""

import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch

from narx.kernels.threads import in_threads

pytestmark = pytest.mark.concurrency

ROOT = Path(__file__).resolve().parents[3]

FORK = """
import os, signal, torch
torch.set_num_threads(2)
from narx.kernels.threads import in_threads
def work():
    done = []
    in_threads(lambda first, last: done.append((first, last)), 64, 8)
    return sorted(done)
expected = work()
child = os.fork()
if child == 0:
    signal.alarm(20)  # ends the child if it hangs
    os._exit(0 if work() == expected else 1)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


def test_a_fork_after_a_fit_does_not_hang():
    answer = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", FORK], capture_output=True, text=True, cwd=ROOT
    )
    assert answer.stdout.strip() == "0", answer.stderr


def test_an_error_is_raised_when_no_part_runs_any_more():
    ended = []

    def work(first, last):
        if first == 0:
            raise ArithmeticError
        time.sleep(0.2)
        ended.append(first)

    n_threads = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        with pytest.raises(ArithmeticError):
            in_threads(work, 2, 1)
    finally:
        torch.set_num_threads(n_threads)
    assert ended == [1]
