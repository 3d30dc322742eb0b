"""Kill commands at random moments, repeat them, and compare what they leave with undisturbed runs.

    python tests/experiments/runs/kill_commands.py FOLDER --kills 100
    python tests/experiments/runs/kill_commands.py FOLDER --commands sweep --kills 10 \
        --sweep optimizer=levenberg_marquardt,lbfgs 'seed=range(8)' hydra/launcher=joblib

Every command is a fork of this process, which has imported the package: most kills then meet a
command at work instead of its imports. Every second kill comes at a random moment, the others at a
random operation on a file of the command's folder. After every kill, each file is either as in the
undisturbed run or, if it holds times, complete; a finished run has all its files.
"""

import argparse
import json
import os
import random
import shutil
import signal
import sys
import time
import traceback
from pathlib import Path

import pandas as pd
import torch
from PIL import Image

from narx.experiments import benchmark, demo_recordings, export, predict, train
from narx.experiments.compare import __main__ as compare
from narx.training import progress

MAINS = {
    "narx-train": train.main,
    "narx-benchmark": benchmark.main,
    "narx-predict": predict.main,
    "narx-export": export.main,
    "narx-compare": compare.main,
    "demo_recordings": demo_recordings.main,
}
SWEEP = ("debug=tiny", "optimizer=levenberg_marquardt,lbfgs", "seed=0,1")
WALK = ("demo_recordings", "output=demo", "duration_s=20")
# the command, and what is to exist before it
COMMANDS = {
    "train": (("narx-train", "debug=tiny", "hydra.run.dir=out"), ()),
    "benchmark": (
        ("narx-benchmark", "debug=tiny", "methods=[zero,narx]", "hydra.run.dir=out"), (),
    ),
    "predict": (
        ("narx-predict", "input=demo/thigh_right.csv", "output=out/angles.csv"), (WALK,),
    ),
    "predict_many": (("narx-predict", "input=demo", "output=out"), (WALK,)),
    "export": (("narx-export", "format=c", "output=out/narx.c"), ()),
    "compare": (
        ("narx-compare", "runs", "--output", "out"),
        (("narx-train", "-m", "debug=tiny", "seed=0,1", "hydra.sweep.dir=runs"),),
    ),
    "sweep": (("narx-train", "-m", *SWEEP, "hydra.sweep.dir=out"), ()),
}  # fmt: skip
# states of trainings, curves that are appended to, and what exists only while a sweep runs
PASSING = ("last", "tensorboard", ".failures", ".submitit")
WRITING = os.O_WRONLY | os.O_RDWR
READERS = {
    ".json": lambda path: json.loads(path.read_text()),
    ".csv": pd.read_csv,
    ".parquet": pd.read_parquet,
    ".pt": lambda path: torch.load(path, weights_only=True),
    ".png": lambda path: Image.open(path).verify(),
}


def kill_at_operation(number, folder):
    """Let this process kill itself at the n-th operation on a file below a folder, 0 for never."""
    seen = []

    def hook(event, arguments):
        writes = event in ("os.rename", "os.remove", "os.chmod", "os.mkdir") or (
            event == "open" and isinstance(arguments[2], int) and arguments[2] & WRITING
        )
        if writes and str(folder) in os.path.abspath(os.fsdecode(str(arguments[0]))):
            seen.append(event)
            if len(seen) == number:
                os.killpg(os.getpid(), signal.SIGKILL)

    sys.addaudithook(hook)
    return seen


def start(command, folder, at_operation=None):
    """Start a command as a fork of this process, with its output in a file."""
    pid = os.fork()
    if pid:
        return pid
    status, seen = 70, []
    try:
        os.setsid()  # so that its workers can be killed with it
        os.chdir(folder)
        said = os.open(folder / "said", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(said, 1)
        os.dup2(said, 2)
        if at_operation is not None:
            seen = kill_at_operation(at_operation, folder / "out")
        sys.argv = list(command)
        MAINS[command[0]]()
        status = 0
    except SystemExit as stop:
        status = stop.code or 0
    except BaseException:
        traceback.print_exc()
    finally:
        (folder / "operations").write_text(str(len(seen)))
        os._exit(status)


def ended(pid):
    """Wait for a command; return its status, negative for a signal."""
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


def to_the_end(command, folder, at_operation=None):
    """Run a command; return its duration in seconds."""
    begun = time.monotonic()
    status = ended(start(command, folder, at_operation))
    if status:
        raise RuntimeError(f"{' '.join(command)}: status {status}\n{(folder / 'said').read_text()}")
    return time.monotonic() - begun


def killed(command, folder, after_s=None, at_operation=None):
    """Kill a command after a time or at an operation; return whether it was still running."""
    pid = start(command, folder, at_operation)
    if after_s is not None:
        until = time.monotonic() + after_s
        while time.monotonic() < until:
            done, status = os.waitpid(pid, os.WNOHANG)
            if done:
                break
            time.sleep(0.01)
        else:
            os.killpg(pid, signal.SIGKILL)
            return ended(pid) == -signal.SIGKILL
        status = os.waitstatus_to_exitcode(status)
    else:
        status = ended(pid)
    if status not in (0, -signal.SIGKILL):
        raise RuntimeError(f"{' '.join(command)}: {status}\n{(folder / 'said').read_text()}")
    return status == -signal.SIGKILL


def files(folder):
    """Name the files that a command leaves, without hidden ones and those of a run at work."""
    return {
        path.relative_to(folder).as_posix(): path
        for path in sorted(folder.rglob("*"))
        if path.is_file()
        and not any(part in PASSING or (part.startswith(".") and part != ".hydra")
                    for part in path.relative_to(folder).parts)
    }  # fmt: skip


def contents(folder):
    """Read all files that a command leaves."""
    return {name: path.read_bytes() for name, path in files(folder).items()}


def check_whole(folder, expected, repeatable):
    """Raise if a file is not whole, or an incomplete run passes for finished."""
    found = files(folder)
    for name, path in found.items():
        state = json.loads(path.read_text())["state"] if path.name == "run.json" else None
        if name in repeatable and state in (None, "finished"):
            if path.read_bytes() != expected[name]:
                raise AssertionError(f"{path} differs from the undisturbed run")
        elif path.suffix in READERS:
            READERS[path.suffix](path)
        elif not path.read_bytes():
            raise AssertionError(f"{path} is empty")
        if state == "finished":
            within = path.parent.relative_to(folder).as_posix().removeprefix(".")
            missing = [n for n in expected if n.startswith(within) and n not in found]
            if missing:
                raise AssertionError(f"{path} is finished without {', '.join(missing)}")


def disturbed_equals_undisturbed(name, command, needed, folder, kills, seed=0):
    """Return how many kills met a command at work; raise if what it leaves differs."""
    twice = [folder / f"{name}_{letter}" for letter in "ab"]
    disturbed = folder / f"{name}_killed"
    for place in (*twice, disturbed):
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        for before in needed:
            to_the_end(before, place)
    to_the_end(command, twice[0], at_operation=0)
    operations = int((twice[0] / "operations").read_text())
    duration_s = to_the_end(command, twice[1])
    expected, again = (contents(place / "out") for place in twice)
    # files without times or names of folders are the same in every run
    repeatable = {key for key in expected if expected[key] == again.get(key)}
    if expected.keys() != again.keys():
        raise AssertionError(f"two runs left {expected.keys() ^ again.keys()}")
    chance, met, alive = random.Random(f"{seed} {name}"), 0, True
    for number in range(kills):
        if not alive or (not number % 3 and (disturbed / "out").is_dir()):
            shutil.rmtree(disturbed / "out")  # begin again, else late kills meet finished work
        if number % 2:
            alive = killed(command, disturbed, after_s=chance.uniform(0, 1) * duration_s)
        else:
            alive = killed(command, disturbed, at_operation=chance.randint(1, operations))
        met += alive
        check_whole(disturbed / "out", expected, repeatable)
    to_the_end(command, disturbed)
    check_whole(disturbed / "out", expected, repeatable)
    if files(disturbed / "out").keys() != expected.keys():
        raise AssertionError(f"{disturbed}: {files(disturbed / 'out').keys() ^ expected.keys()}")
    print(
        f"{name}: {met} of {kills} kills met it at work; {len(repeatable)} of {len(expected)} "
        "files the same bit for bit, the others complete",
        flush=True,
    )
    return met


def same_tables(folder):
    """Compare the tables over an undisturbed and a killed sweep; raise if they differ."""
    tables = []
    for name in ("sweep_a", "sweep_killed"):
        to_the_end(("narx-compare", "out"), folder / name)
        tables.append(
            [(folder / name / "out" / f"runs.{end}").read_bytes() for end in ("csv", "parquet")]
        )
    if tables[0] != tables[1]:
        raise AssertionError(f"{folder}: the tables of sweep_a and sweep_killed differ")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kills", type=int, default=100, help="over all commands")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--commands", nargs="+", choices=COMMANDS, default=list(COMMANDS))
    parser.add_argument("--sweep", nargs="+", default=SWEEP, help="overrides of the sweep")
    arguments = parser.parse_args()
    folder = arguments.folder.absolute()
    progress.INTERVAL_S = 0.1  # so that short trainings leave states too
    met = 0
    for place, name in enumerate(arguments.commands):
        command, needed = COMMANDS[name]
        if name == "sweep":
            command = ("narx-train", "-m", *arguments.sweep, "hydra.sweep.dir=out")
        kills = len(range(place, arguments.kills, len(arguments.commands)))
        met += disturbed_equals_undisturbed(name, command, needed, folder, kills, arguments.seed)
        if name == "sweep":
            same_tables(folder)
            print("the same table, bit for bit")
    print(f"{met} of {arguments.kills} kills met a command at work")


if __name__ == "__main__":
    main()
