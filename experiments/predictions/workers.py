"""Run jobs in this process, in several processes, or on a Dask cluster."""

import contextlib
import logging
import math
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import CancelledError, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from tqdm import tqdm

from narx.errors import UserError
from narx.experiments.predictions.jobs import Job, Outcome

# starting a worker takes as long as a dozen files
_ENOUGH_FOR_PROCESSES = 50
_CONNECT_S = 10
# intervals at which results and workers of a cluster are looked for
_POLL_S, _LOOK_S = 0.02, 1.0
# time without workers after which this is said
_PATIENCE_S = 10.0
# read by the libraries when they are loaded
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def outcomes(
    jobs: Sequence[Job], n_workers: int | None, scheduler: str | None
) -> Generator[Outcome, None, None]:
    """Run jobs, and yield the outcome of each as it ends.

    Parameters
    ----------
    jobs : sequence of Job
        Jobs to run.
    n_workers : int, optional
        Number of processes on this machine; None uses one, or one per core for 50 jobs or more.
    scheduler : str, optional
        Address of a Dask scheduler, such as ``tcp://host:8786``; its workers need access to the
        same files.

    Yields
    ------
    Outcome
        In the order of completion.

    Raises
    ------
    UserError
        If the scheduler cannot be reached, Dask is not installed, or a process was killed.
    """
    if scheduler is not None:
        yield from _on_cluster(jobs, scheduler)
        return
    wanted = n_workers or (os.cpu_count() or 1 if len(jobs) >= _ENOUGH_FOR_PROCESSES else 1)
    if min(wanted, len(jobs)) <= 1:
        for job in jobs:
            yield job.run()
        return
    with _libraries_on_one_core(), _pool(min(wanted, len(jobs))) as pool:
        with _ctrl_c_ignored():  # and by the processes that start here
            futures = [pool.submit(_run, job) for job in jobs]
        try:
            for finished in as_completed(futures):
                yield finished.result()
        except BrokenProcessPool:
            raise UserError(
                f"jobs: one of {wanted} processes was ended from outside, for example for lack of "
                "memory; the same command goes on with the recordings that are not finished"
            ) from None
        except BaseException:  # the pool would wait for all jobs
            for process in multiprocessing.active_children():
                process.terminate()
            raise


def _pool(n_workers: int) -> ProcessPoolExecutor:
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(n_workers, mp_context=context, initializer=_on_one_core)


def _on_cluster(jobs: Sequence[Job], scheduler: str) -> Iterator[Outcome]:
    try:
        import distributed
    except ImportError:
        raise UserError(
            f"scheduler is '{scheduler}', which needs Dask: pip install 'narx-orientation[cluster]'"
        ) from None
    # prints a traceback when the scheduler goes away, which is one line here
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    try:
        client = distributed.Client(scheduler, timeout=_CONNECT_S)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split())[:160]
        raise UserError(f"scheduler: no Dask scheduler at '{scheduler}' ({reason})") from None
    with client:
        # pure=False: the same job gives another result after a change of its input
        futures = client.map(_run_in_folder, jobs, folder=os.getcwd(), pure=False)
        running = distributed.as_completed(futures)
        try:
            while not running.is_empty():
                _await_result(client, running, scheduler)
                yield next(running).result()
        except (distributed.KilledWorker, CancelledError) as error:
            lost = (
                "its workers" if isinstance(error, distributed.KilledWorker) else "the connection"
            )
            reason = " ".join(str(error).split())[:160]
            raise UserError(
                f"scheduler: '{scheduler}' lost {lost} ({reason}); the same command goes on "
                "with the recordings that are not finished"
            ) from None


def _await_result(client: Any, running: Any, scheduler: str) -> None:
    """Wait for the next result; say so once if the cluster has had no worker for a while.

    A queue or an adaptive cluster may start one later, so this does not end the command.
    """
    looked, with_workers = time.monotonic(), time.monotonic()
    while not running.has_ready():
        time.sleep(_POLL_S)
        now = time.monotonic()
        if now - looked < _LOOK_S:
            continue
        looked = now
        if _has_workers(client):
            with_workers = now
        elif now - with_workers >= _PATIENCE_S:
            tqdm.write(
                f"scheduler: '{scheduler}' has no workers; waiting for one (Ctrl-C ends this, "
                "finished work is kept)",
                file=sys.stderr,
            )
            with_workers = math.inf


def _has_workers(client: Any) -> bool:
    try:
        return bool(client.nthreads())
    except OSError:  # the scheduler is gone, which cancels the results
        return False


def _run(job: Job) -> Outcome:
    return job.run()


def _run_in_folder(job: Job, folder: str) -> Outcome:
    """Run in the client's folder, so that relative paths and messages are the same."""
    os.chdir(folder)
    _on_one_core()
    return job.run()


@contextlib.contextmanager
def _ctrl_c_ignored() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def _libraries_on_one_core() -> Iterator[None]:
    """Let processes that start now use one thread for linear algebra each."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update({name: "1" for name in _THREADS if before[name] is None})
    try:
        yield
    finally:
        for name in _THREADS:
            if before[name] is None:
                del os.environ[name]


def _on_one_core() -> None:
    """Limit the process to one core, since there are as many workers as cores."""
    import torch

    torch.set_num_threads(1)
