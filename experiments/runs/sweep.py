"""End of a sweep: all jobs have run, and each failed job is reported in one line."""

import contextlib
import json
import math
import shutil
import sys
import time
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, RangeSweep
from hydra.core.utils import JobReturn, JobStatus
from hydra.experimental.callback import Callback
from hydra.types import RunMode
from omegaconf import DictConfig

from narx.errors import user_error_behind
from narx.experiments.runs.folder import RECORD, is_abandoned
from narx.experiments.runs.record import write_json

USER_ERROR_STATUS = 2
_FAULT_STATUS = 1
# Hydra composes the configurations of all of them before the first begins
_MAX_JOBS = 10_000


def _wrong_number_of_jobs(overrides: Sequence[Override]) -> str | None:
    """Return what is wrong with the values of a sweep; all of them would be listed first."""
    n_jobs = 1.0
    for override in overrides:
        value, n_values = override.value(), 1.0
        if isinstance(value, RangeSweep):  # not listed, since it may have no end
            begin, end, step = (float(v) for v in (value.start, value.stop, value.step))  # type: ignore[arg-type]
            n_values = math.ceil((end - begin) / step) if step else math.inf
        elif override.is_discrete_sweep():
            n_values = len(list(override.sweep_iterator()))
        if n_values <= 0:
            return f"{override.input_line}: no value to run with"
        n_jobs *= n_values
        if n_jobs > _MAX_JOBS:
            return f"{override.input_line}: makes {n_jobs:g} jobs, expected at most {_MAX_JOBS}"
    return None


class SweepReport(Callback):
    """Collect the failed jobs of a sweep, with any launcher and sweeper.

    A job may run in another process or on another machine, so it writes the reason of its failure
    to a file in the sweep's folder.
    """

    # the instance of this process; Hydra gives no access to its callbacks
    current: ClassVar["SweepReport | None"] = None

    def __init__(self) -> None:
        self._failures: Path | None = None
        self._created: list[Path] = []
        self._begun_s = 0.0

    def on_multirun_start(self, config: DictConfig, **further: Any) -> None:
        """Name the jobs' folders by the overrides that vary, and prepare the reports of failures.

        Parameters
        ----------
        config : omegaconf.DictConfig
            Configuration of the sweep; its Hydra overrides reach every job.
        **further : object
            What else Hydra gives.
        """
        sweep = Path(config.hydra.sweep.dir).absolute()
        with contextlib.suppress(OSError):  # if it fails here, Hydra's own attempt reports it
            self._created = [path for path in (sweep, *sweep.parents) if not path.exists()]
            sweep.mkdir(parents=True, exist_ok=True)
        self._failures = sweep / ".failures" / uuid.uuid4().hex
        self._begun_s = time.time()
        SweepReport.current = self
        # which knows the files that a glob stands for
        parser = OverridesParser.create(GlobalHydra.instance().config_loader())
        overrides = parser.parse_overrides(list(config.hydra.overrides.task))
        if "study_name" not in config.hydra.sweeper:  # Optuna draws from the ranges
            problem = _wrong_number_of_jobs(overrides)
            if problem:  # Hydra turns exceptions of its callbacks into warnings
                print(f"error: {problem}", file=sys.stderr)
                sys.exit(USER_ERROR_STATUS)
        fixed = [o.get_key_element() for o in overrides if not o.is_sweep_override()]
        exclude = ",".join(f"'{key}'" for key in fixed)
        config.hydra.overrides.hydra.append(
            f"hydra.job.config.override_dirname.exclude_keys=[{exclude}]"
        )

    def on_job_end(self, config: DictConfig, job_return: JobReturn, **further: Any) -> None:
        """Record why a job of the sweep has failed, and let the sweep continue.

        Parameters
        ----------
        config : omegaconf.DictConfig
            Configuration of the job.
        job_return : hydra.core.utils.JobReturn
            A failed job is changed to one without a value: sweepers would otherwise raise before
            the other jobs have run. Optuna counts it as a failed trial.
        **further : object
            What else Hydra gives.
        """
        if self._failures is None or config.hydra.mode != RunMode.MULTIRUN:
            return
        if job_return.status != JobStatus.FAILED:
            return
        error = job_return._return_value  # the property would raise the exception
        mistake = user_error_behind(error)
        write_json(
            {
                "job": config.hydra.job.num,
                "overrides": config.hydra.job.override_dirname,
                "reason": " ".join(str(mistake or f"{type(error).__name__}: {error}").split()),
                "user_error": mistake is not None,
                "folder": config.hydra.runtime.output_dir,
            },
            self._failures / f"{config.hydra.job.num}.json",
        )
        job_return.status = JobStatus.COMPLETED
        job_return.return_value = None

    def on_multirun_end(self, config: DictConfig, **further: Any) -> None:
        """End the command with a status other than zero if some jobs have failed.

        Parameters
        ----------
        config : omegaconf.DictConfig
            Configuration of the sweep.
        **further : object
            What else Hydra gives.
        """
        status = self.report()
        print(f"table of all runs: narx-compare {config.hydra.sweep.dir}")
        if status:
            sys.exit(status)

    def report(self) -> int:
        """Print a line for each failed job.

        Returns
        -------
        int
            Exit status: 0 if no job failed, 2 if all failures are user errors, otherwise 1.
        """
        if self._failures is None or not self._failures.is_dir():
            return 0
        failures = sorted(
            (json.loads(path.read_text()) for path in self._failures.glob("*.json")),
            key=lambda failure: failure["job"],
        )
        for failure in failures:
            where = "" if failure["user_error"] else f" (traceback.txt in {failure['folder']})"
            print(
                f"error: job {failure['job']} ({failure['overrides']}): {failure['reason']}{where}",
                file=sys.stderr,
            )
        shutil.rmtree(self._failures)
        return USER_ERROR_STATUS if all(f["user_error"] for f in failures) else _FAULT_STATUS

    def remove_unused(self) -> None:
        """Remove the folders that this launch has created, if no job has begun in them.

        The sweeper writes ``multirun.yaml`` before it composes the jobs' configurations.
        """
        if not self._created:
            return
        sweep, *parents = self._created
        with contextlib.suppress(OSError):  # not there; not empty, because others use it
            if any(path.is_dir() for path in sweep.iterdir()):
                return
            shutil.rmtree(sweep)
            for parent in parents:
                parent.rmdir()

    def report_killed(self) -> int:
        """Print a line for each run whose process has ended without recording how.

        Returns
        -------
        int
            Exit status: 0 if there is none, otherwise 1.
        """
        if self._failures is None:
            return 0
        killed = [
            path.parent
            for path in sorted(self._failures.parents[1].glob(f"*/{RECORD}"))
            if path.stat().st_mtime >= self._begun_s and is_abandoned(path.parent)
        ]
        for folder in killed:
            print(
                f"error: {folder}: its process has ended without a result, for example killed "
                "for lack of memory; repeat the command to run what is missing",
                file=sys.stderr,
            )
        return _FAULT_STATUS if killed else 0
