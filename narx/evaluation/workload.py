"""Resources of a run: time in each method, and memory."""

import re
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Workload:
    """Timing of a benchmark, stored apart from its results because it differs between runs.

    Parameters
    ----------
    methods_s : dict of str to float
        CPU time of the calling thread in each method's estimates, s. Wall time would include
        concurrent work, such as the preparation of the next trial.
    n_samples : dict of str to int
        Number of samples estimated by each method.
    training_s : float
        Time in training including data loading, s.
    """

    methods_s: dict[str, float] = field(default_factory=dict)
    n_samples: dict[str, int] = field(default_factory=dict)
    training_s: float = 0.0

    def __post_init__(self) -> None:
        self._begun = time.perf_counter()
        self._adding = threading.Lock()

    @contextmanager
    def of_method(self, name: str, n_samples: int) -> Iterator[None]:
        """Add the run time of the block to a method.

        Parameters
        ----------
        name : str
            Name of the method.
        n_samples : int
            Number of samples that it estimates.

        Yields
        ------
        None
            Once.
        """
        begun = time.thread_time()
        try:
            yield
        finally:
            spent = time.thread_time() - begun
            with self._adding:
                self.methods_s[name] = self.methods_s.get(name, 0.0) + spent
                self.n_samples[name] = self.n_samples.get(name, 0) + n_samples

    @property
    def us_per_sample(self) -> dict[str, float]:
        """CPU time of each method for one sample, all three axes, microseconds."""
        return {n: 1e6 * self.methods_s[n] / count for n, count in self.n_samples.items() if count}

    def report(self) -> dict[str, object]:
        """Summarise for ``timing.json``.

        Returns
        -------
        dict
            Seconds in each method and microseconds per sample (all three axes), seconds in all
            methods, in training and in the whole run; peak memory of the process in MiB, None where
            the system does not report it.
        """
        return {
            "methods_s": dict(sorted(self.methods_s.items())),
            "us_per_sample": dict(sorted(self.us_per_sample.items())),
            "all_methods_s": sum(self.methods_s.values()),
            "training_s": self.training_s,
            "run_s": time.perf_counter() - self._begun,
            "peak_memory_mib": peak_memory_mib(),
        }


def peak_memory_mib() -> float | None:
    """Return the peak memory of this process.

    Returns
    -------
    float or None
        Resident set in MiB; None where the system does not report it.
    """
    status = Path("/proc/self/status")
    if status.exists():  # getrusage may return the parent's peak, if that was larger at the fork
        found = re.search(r"VmHWM:\s*(\d+) kB", status.read_text())
        return float(found[1]) / 2.0**10 if found else None
    if sys.platform == "win32":
        return None
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2.0**20
