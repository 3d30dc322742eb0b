"""Kill and restart a sweep until it finishes, and compare it with an uninterrupted one.

python tests/experiments/runs/kill_sweep.py FOLDER --kills 10 optimizer=levenberg_marquardt,lbfgs \
    'seed=range(4)' hydra/launcher=joblib
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

TRAIN = (sys.executable, "-m", "narx.experiments.train", "-m")


def launch(overrides, folder):
    return subprocess.Popen(
        [*TRAIN, *overrides, f"hydra.sweep.dir={folder}"],
        start_new_session=True,  # so that its workers can be killed with it
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def run_to_the_end(overrides, folder):
    """Run a sweep; return its output and its duration."""
    begun = time.monotonic()
    process = launch(overrides, folder)
    said, _ = process.communicate()
    if process.returncode:
        raise RuntimeError(said)
    return said, time.monotonic() - begun


def run_and_kill(overrides, folder, after_s):
    """Kill a sweep and its workers; return whether it was still running."""
    process = launch(overrides, folder)
    try:
        process.communicate(timeout=after_s)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return True
    return False


def tables(folder):
    """Compare the sweep's runs; return the bytes of both tables."""
    subprocess.run(
        [sys.executable, "-m", "narx.experiments.compare", str(folder)],
        check=True,
        capture_output=True,
    )
    return [(folder / name).read_bytes() for name in ("runs.csv", "runs.parquet")]


def disturbed_equals_undisturbed(folder, overrides, kills, seed=0):
    """Return how many of the kills met a sweep at work; raise if the tables differ."""
    peaceful, disturbed = Path(folder, "peaceful"), Path(folder, "disturbed")
    _, duration_s = run_to_the_end(overrides, peaceful)
    moments = random.Random(seed)
    met = sum(
        # the undisturbed sweep comes first and also fills the caches, so it takes longer
        run_and_kill(overrides, disturbed, moments.uniform(0.1, 0.5) * duration_s)
        for _ in range(kills)
    )
    run_to_the_end(overrides, disturbed)
    if tables(peaceful) != tables(disturbed):
        raise AssertionError(f"{peaceful} and {disturbed} differ")
    return met


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    arguments, overrides = parser.parse_known_args()
    met = disturbed_equals_undisturbed(arguments.folder, overrides, arguments.kills, arguments.seed)
    print(f"the same table, bit for bit; {met} of {arguments.kills} kills met a sweep at work")


if __name__ == "__main__":
    main()
