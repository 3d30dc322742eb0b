"""Predict a recording of many hours and a folder of many files: memory, time, kills, Dask.

python -m experiments.endurance output=endurance

Every prediction is a process of its own, as a user starts it. The measured values are printed; a
difference between files that must be identical ends the command with status 2.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet
from omegaconf import DictConfig
from threadpoolctl import threadpool_limits

from narx.datasets import SimulatedGait, read_recording, write_recording
from narx.errors import UserError
from narx.experiments.command import command
from narx.files import atomic_path
from narx.inference.predict import predict
from narx.inference.pretrained import load_or_pretrained
from narx.recordings.trial import ImuRecording

SEGMENTS = ("thigh_right", "shank_right", "thigh_left", "shank_left")
RATE_HZ = 100.0
# simulated once and repeated; begins with standing
_WALK_S = 300.0
_FILE_S = 60.0
_POLL_S = 0.2
_TIMED_FILES = 20


@dataclass(frozen=True)
class Usage:
    """Resources of a command.

    Parameters
    ----------
    status : int
        Exit status; negative: the signal that ended it.
    wall_s, cpu_s : float
        Elapsed time, and processor time of all its processes.
    peak_mib : float
        Largest resident memory of all its processes together, MiB, sampled five times a second.
    """

    status: int
    wall_s: float
    cpu_s: float
    peak_mib: float


def run_predict(overrides: list[str], kill_when: Path | None = None) -> Usage:
    """Run `narx-predict` in its own process group.

    Parameters
    ----------
    overrides : list of str
        Its options.
    kill_when : pathlib.Path, optional
        All its processes are killed (SIGKILL) as soon as this file exists.

    Returns
    -------
    Usage
        What it took.
    """
    before, begin, peak = os.times(), time.perf_counter(), 0.0
    process = subprocess.Popen(
        [sys.executable, "-m", "narx.experiments.predict", *overrides],
        start_new_session=True, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    while process.poll() is None:
        peak = max(peak, _group_mib(process.pid))
        if kill_when is not None and kill_when.exists():
            os.killpg(process.pid, signal.SIGKILL)
        time.sleep(_POLL_S)
    after = os.times()
    cpu = after.children_user + after.children_system
    cpu -= before.children_user + before.children_system
    return Usage(process.returncode, time.perf_counter() - begin, cpu, peak)


def _group_mib(group: int) -> float:
    """Resident memory of a process group according to ``/proc``, MiB."""
    pages = 0
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if os.getpgid(int(entry.name)) == group:
                    pages += int((entry / "statm").read_text().split()[1])
            except (OSError, IndexError):
                continue  # ended meanwhile
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def simulated_walk(duration_s: float = _WALK_S) -> dict[str, ImuRecording]:
    """Simulate one walk with four sensors, at 100 Hz.

    Parameters
    ----------
    duration_s : float
        Duration of the walk, s.

    Returns
    -------
    dict of str to ImuRecording
        Recording of each segment.
    """
    source = SimulatedGait(
        subjects=("S1",), conditions=("normal",), treadmill_duration_s=duration_s,
        sampling_rate_hz=RATE_HZ,
    )  # fmt: skip
    trial = next(iter(source))
    return {segment: trial.imus[segment] for segment in SEGMENTS}


def write_session(walk: dict[str, ImuRecording], folder: Path, duration_s: float) -> list[str]:
    """Write one Parquet file per sensor, with the walk repeated.

    Parameters
    ----------
    walk : mapping of str to ImuRecording
        From `simulated_walk`.
    folder : pathlib.Path
        Folder of the files; existing ones are kept.
    duration_s : float
        Duration of the session, s.

    Returns
    -------
    list of str
        Option of `narx-predict` that names them.
    """
    n_samples = round(duration_s * RATE_HZ)
    for segment, imu in walk.items():
        path = folder / f"{segment}.parquet"
        if path.exists():
            continue
        values = np.column_stack([imu.gyroscope_rad_s, imu.accelerometer_m_s2])
        names = ["time_s"] + [
            f"{sensor}_{axis}_{unit}"
            for sensor, unit in (("gyroscope", "rad_s"), ("accelerometer", "m_s2"))
            for axis in "xyz"
        ]
        schema = pyarrow.schema([(name, pyarrow.float64()) for name in names])
        with (
            atomic_path(path) as temporary,
            pyarrow.parquet.ParquetWriter(temporary, schema) as writer,
        ):
            for start in range(0, n_samples, len(values)):
                part = values[: n_samples - start]
                times = np.arange(start, start + len(part)) / RATE_HZ
                writer.write_table(pyarrow.table([times, *part.T], schema=schema))
    files = ", ".join(f"{segment}: {folder / segment}.parquet" for segment in walk)
    return [f"input={{{files}}}", "format=parquet"]


def identical(one: Path, other: Path) -> int:
    """Compare the angles in two folders.

    Parameters
    ----------
    one, other : pathlib.Path
        Folders with files ``*_angles.*``.

    Returns
    -------
    int
        Number of identical files.

    Raises
    ------
    UserError
        If names or bytes differ, or there are no files.
    """
    found = [sorted(path.name for path in folder.rglob("*_angles.*")) for folder in (one, other)]
    if found[0] != found[1] or not found[0]:
        raise UserError(f"'{one}' has {len(found[0])} files, '{other}' {len(found[1])}")
    for path in one.rglob("*_angles.*"):
        if path.read_bytes() != (other / path.relative_to(one)).read_bytes():
            raise UserError(f"'{path}' and its counterpart in '{other}' differ")
    return len(found[0])


def _session(cfg: DictConfig, folder: Path) -> None:
    n_parts = int(cfg.hours * 4)
    options = write_session(simulated_walk(), folder / "session", cfg.hours * 3600.0)
    options += [f"jobs={cfg.jobs}"]
    middle = folder / "killed" / f"{n_parts // 2:04d}_angles.parquet"
    if not middle.exists():
        killed = run_predict([*options, f"output={folder / 'killed'}"], kill_when=middle)
        print(f"killed midway (status {killed.status}), peak {killed.peak_mib:.0f} MiB", flush=True)
    _print("after the kill", run_predict([*options, f"output={folder / 'killed'}"]))
    _print(f"{cfg.hours:g} h at once", run_predict([*options, f"output={folder / 'whole'}"]))
    print(f"{identical(folder / 'killed', folder / 'whole')} identical files", flush=True)


def _dask(cfg: DictConfig, folder: Path) -> None:
    options = write_session(simulated_walk(), folder / "short", cfg.dask_minutes * 60.0)
    options += ["partition_s=300"]
    _print("one process", run_predict([*options, f"output={folder / 'alone'}", "jobs=1"]))
    with _two_workers() as address:
        usage = run_predict([*options, f"output={folder / 'dask'}", f"scheduler={address}"])
    _print("two Dask workers", usage)
    print(f"{identical(folder / 'alone', folder / 'dask')} identical files", flush=True)


@contextmanager
def _two_workers() -> Iterator[str]:
    import distributed

    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        yield str(cluster.scheduler_address)


def _folder(cfg: DictConfig, folder: Path) -> None:
    walk = simulated_walk(_FILE_S)["thigh_right"]
    begin = folder / "files"
    for number in range(cfg.files):
        path = begin / f"{number:04d}.csv"
        if not path.exists():
            write_recording(path, walk)
    method = load_or_pretrained(None).method(False)
    computing = []
    for number in range(min(_TIMED_FILES, cfg.files)):
        recording = read_recording(begin / f"{number:04d}.csv")
        started = time.process_time()
        with threadpool_limits(1, user_api="blas"):  # as narx-predict
            predict(recording, method)
        computing.append(time.process_time() - started)
    middle = folder / "angles" / f"{cfg.files // 2:04d}_csv_angles.csv"
    options = [f"input={begin}", f"output={folder / 'angles'}", f"jobs={cfg.jobs}"]
    killed = run_predict(options, kill_when=middle)
    finished = run_predict(options)
    _print(f"rest of {cfg.files} files after a kill (status {killed.status})", finished)
    whole = run_predict([f"input={begin}", f"output={folder / 'again'}", f"jobs={cfg.jobs}"])
    _print(f"{cfg.files} files at once", whole)
    pure = float(np.median(computing)) * cfg.files
    print(f"computing alone {pure:.1f} s of processor time: ratio {whole.cpu_s / pure:.2f}")
    print(f"{identical(folder / 'angles', folder / 'again')} identical files", flush=True)


def _print(what: str, usage: Usage) -> None:
    if usage.status:
        raise UserError(f"{what}: narx-predict ended with status {usage.status}")
    print(
        f"{what}: {usage.wall_s:.0f} s, {usage.cpu_s:.0f} s of processor time, "
        f"peak {usage.peak_mib:.0f} MiB",
        flush=True,
    )


def _measure(cfg: DictConfig) -> None:
    folder = Path(str(cfg.output)).absolute()
    if cfg.dask_minutes:
        _dask(cfg, folder)
    if cfg.files:
        _folder(cfg, folder)
    if cfg.hours:
        _session(cfg, folder)


main = command("endurance", keeps_run=False)(_measure)

if __name__ == "__main__":
    main()
