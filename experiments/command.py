"""Common to all commands: overrides, the run's folder, error messages and exit status."""

import contextlib
import cProfile
import errno
import functools
import logging
import os
import pstats
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig
from omegaconf.errors import OmegaConfBaseException

from narx.errors import UserError, user_error_behind
from narx.experiments import menu
from narx.experiments.configuration import checked_configuration, composition_mistake
from narx.experiments.overrides import readable
from narx.experiments.runs.folder import claimed
from narx.experiments.runs.identity import register_resolvers
from narx.experiments.runs.sweep import USER_ERROR_STATUS, SweepReport
from narx.experiments.sources import data_sha256
from narx.experiments.starting import (
    INTERRUPTED_STATUS,
    end_if_output_is_closed,
    imported,
    interrupted,
    pipe_may_close,
)

CONFIG_PATH = "pkg://narx.configs"
# the file system refuses the write: not a bug of the program
_REFUSED = (
    errno.EROFS, errno.EACCES, errno.EPERM, errno.ENOSPC, errno.EDQUOT, errno.ENOTDIR,
    errno.EISDIR, errno.ENOENT, errno.ENAMETOOLONG, errno.ELOOP, errno.EFBIG,
)  # fmt: skip
_SWEEP = {"-m", "--multirun"}
# subfolder of an unfinished run, with the states of its trainings
_LAST = "last"
# number of functions of a profile that are printed, the slowest first
_FUNCTIONS_SHOWN = 30

register_resolvers()
menu.register_resolvers()


@contextlib.contextmanager
def _mistakes_end_with_one_line(config_name: str) -> Iterator[None]:
    try:
        yield
    except Exception as error:
        if interrupted():
            raise KeyboardInterrupt from error
        end_if_output_is_closed(error)
        mistake = user_error_behind(error)
        if mistake is not None:
            sys.exit(_report(str(mistake)))
        if isinstance(error, HydraException | OmegaConfBaseException):
            sys.exit(_report(composition_mistake(error, config_name, sys.argv[1:])))
        if isinstance(error, OSError) and error.errno in _REFUSED:
            sys.exit(_report(_about_writing(error)))
        raise


def _about_writing(error: OSError) -> str:
    where = error.filename or "the run's folder"
    return (
        f"{where}: {error.strerror}; expected a writable location: another working "
        "directory, or hydra.run.dir=DIR (with -m hydra.sweep.dir=DIR)"
    )


def in_sweep() -> bool:
    """Tell whether this run is a job of a sweep.

    Returns
    -------
    bool
        False for a single run.
    """
    return bool(HydraConfig.get().mode == RunMode.MULTIRUN)


def command(
    config_name: str, *, keeps_run: bool = True
) -> Callable[[Callable[[DictConfig], object]], Callable[[], None]]:
    """Turn a function of a configuration into a command with Hydra overrides.

    Parameters
    ----------
    config_name : str
        Primary configuration below `configs/`.
    keeps_run : bool
        Whether a run has a folder (`narx.experiments.runs.folder`). A finished run is not
        repeated; its value is returned. Without a folder, the command does not support sweeps.

    Returns
    -------
    callable
        Decorator. The command ends with status 2 and one line on standard error if the user has
        to fix something (`UserError`, or a configuration that cannot be composed), and with a
        traceback only for a bug of the program. In a sweep, all other jobs run, and one such line
        is printed for each failed job.
    """

    imported()  # the last statement of a command's module

    def decorate(function: Callable[[DictConfig], object]) -> Callable[[], None]:
        started = False

        @functools.wraps(function)
        def job(cfg: DictConfig) -> object:
            nonlocal started
            started = True
            _show_compiling()
            if in_sweep() and keeps_run:
                # the launcher receives a failure as an exception
                return _kept(function, checked_configuration(cfg, config_name))
            # within the job, since Hydra adds a line of its own to an exception that leaves it
            with _mistakes_end_with_one_line(config_name):
                checked = checked_configuration(cfg, config_name)
                return _kept(function, checked) if keeps_run else function(checked)

        task = hydra.main(version_base="1.3", config_path=CONFIG_PATH, config_name=config_name)(job)

        @pipe_may_close()
        def main() -> None:
            """Run the command with the overrides on the command line."""
            # makes Hydra raise, instead of printing and exiting with status 1 itself
            os.environ["HYDRA_FULL_ERROR"] = "1"
            # Hydra's parser takes no overrides on both sides of a flag
            sys.argv[1:] = sorted(readable(sys.argv[1:]), key=lambda one: one not in _SWEEP)
            # it would print a traceback for every message after the reader of the output has gone
            logging.raiseExceptions = False
            nonlocal started
            started = False
            SweepReport.current = None
            try:
                with _mistakes_end_with_one_line(config_name):
                    if not keeps_run and _SWEEP & set(sys.argv):
                        raise UserError(
                            f"{config_name} -m: sweeps are not supported; use one call per file"
                        )
                    task()
            except KeyboardInterrupt:
                sys.exit(_interrupted(begun=started))
            except Exception as error:
                end_if_output_is_closed(error)
                if isinstance(error, OSError) and not started:  # a file of that name
                    sys.exit(_report(_about_writing(error)))
                # e.g. Optuna raises when there is no best trial because all have failed, and
                # launchers when the process of a job was killed
                report = SweepReport.current
                status = 0 if report is None else max(report.report(), report.report_killed())
                if status == 0 and not started:  # Hydra's plugins raise exceptions of any type
                    status = _report(composition_mistake(error, config_name, sys.argv[1:]))
                if status == 0:
                    raise
                sys.exit(status)
            finally:
                if SweepReport.current is not None:
                    SweepReport.current.remove_unused()

        main.__module__ = function.__module__
        return main

    return decorate


@functools.cache  # one handler for each process, including a launcher's workers
def _show_compiling() -> None:
    compiling = logging.getLogger("narx.kernels.cache")
    compiling.propagate = False  # Hydra would write a log file in the run's folder
    if sys.stderr.isatty():
        compiling.addHandler(logging.StreamHandler())
        compiling.setLevel(logging.INFO)


def _kept(function: Callable[[DictConfig], object], cfg: DictConfig) -> object:
    folder = run_directory()
    with claimed(folder, cfg, data_sha256(cfg)) as run:
        if run.finished:
            print(f"{folder}: already finished, nothing to do")
            return run.record.get("value")
        try:
            value = _profiled(function, cfg, folder) if cfg.get("profile") else function(cfg)
        except KeyboardInterrupt:
            if not in_sweep():
                _print_interrupted(f"repeat the command with hydra.run.dir={folder} to continue")
                sys.exit(INTERRUPTED_STATUS)
            raise
        except SystemExit as stop:
            if in_sweep():  # it would end the other jobs, too
                raise RuntimeError(f"the job has called sys.exit({stop.code})") from stop
            raise
        except Exception as error:
            if interrupted():
                raise KeyboardInterrupt from error
            end_if_output_is_closed(error)
            raise
        shutil.rmtree(folder / _LAST, ignore_errors=True)
        run.end("finished", value=value)
    return value


def _profiled(function: Callable[[DictConfig], object], cfg: DictConfig, folder: Path) -> object:
    profile = cProfile.Profile()
    value = profile.runcall(function, cfg)
    profile.dump_stats(folder / "profile.pstats")
    pstats.Stats(profile).sort_stats("cumulative").print_stats(_FUNCTIONS_SHOWN)
    return value


def _interrupted(begun: bool) -> int:
    if SweepReport.current is None:
        # a command without a run folder finds its own output again
        how = "do the rest" if begun else "start again"
        _print_interrupted(f"repeat the command to {how}")
    else:
        SweepReport.current.report()
        _print_interrupted("repeat the command to run the unfinished jobs")
    return INTERRUPTED_STATUS


def _print_interrupted(how_to_continue: str) -> None:
    print(f"\ninterrupted: finished work is kept; {how_to_continue}", file=sys.stderr)


def _report(message: str) -> int:
    print(f"error: {message}", file=sys.stderr)
    return USER_ERROR_STATUS


def run_directory() -> Path:
    """Return the directory that Hydra created for this run.

    Returns
    -------
    pathlib.Path
        Where all output of the run is written.
    """
    return Path(HydraConfig.get().runtime.output_dir)


def states_folder(cfg: DictConfig) -> Path:
    """Return the folder in which the states of this run's trainings are kept until it has finished.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With ``resume=never``, states left by an interrupted launch are deleted.

    Returns
    -------
    pathlib.Path
        Folder, as `progress_folder` of `narx.Trainer`.
    """
    folder = run_directory() / _LAST
    if cfg.resume == "never":
        shutil.rmtree(folder, ignore_errors=True)
    return folder
