"""Time of the first use, which compiles the kernels, and of later ones."""

import os
import subprocess
import sys
import tempfile
import time

import numpy as np

_PROGRAM = """
import time; start = time.perf_counter()
import numpy as np, torch
from narx.network.closed_loop import closed_loop
from narx.experiments.speed.task import STRUCTURE, open_then_closed, random_starts
from narx.training.multi_start import multi_start
imported = time.perf_counter()
v = np.random.default_rng(0).standard_normal(200)
stages = open_then_closed(v, 0.1 * v)
best = multi_start(stages, random_starts(16, np.random.default_rng(0)), stages[-1].problem)
weights, inputs = torch.from_numpy(best.weights), torch.from_numpy(v)[:, None]
closed_loop(weights, inputs, structure=STRUCTURE)
closed_loop(weights, inputs.expand(9, 200, 1), structure=STRUCTURE)
print(time.perf_counter() - imported)
"""


def first_use() -> dict[str, float]:
    """Time a run with an empty cache, then one with the filled cache.

    Returns
    -------
    dict of str to float
        ``first_use_s`` and ``later_use_s``, from the imports to the end of a small training with a
        rollout of one and of many channels; ``import_narx_s``, of a process that only imports the
        package. All in s.
    """
    result = {}
    with tempfile.TemporaryDirectory() as cache:
        for name in ("first_use_s", "later_use_s"):
            run = subprocess.run(
                [sys.executable, "-c", _PROGRAM],
                env=os.environ | {"NUMBA_CACHE_DIR": cache},
                check=True,
                capture_output=True,
                text=True,
            )
            result[name] = float(run.stdout)
    times = []
    for _ in range(3):
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", "import narx"], check=True)
        times.append(time.perf_counter() - start)
    return result | {"import_narx_s": float(np.median(times))}
