"""Change lines of the package on purpose, and see that the named tests notice.

Each entry of ``changed_lines.toml`` names a file, an original text that occurs in it once, what
replaces it, and the test files that are to fail. Run alone for all entries, or for those whose
description or file contains one of the words::

    python tests/changed_lines.py [word ...]

The changes are made in a copy of the package. Every test run is a forked child of one process that
has imported the libraries already, so an entry takes little more than its tests.
"""

import gc
import importlib
import os
import shutil
import signal
import sys
import tempfile
import tomllib
import traceback
from pathlib import Path
from typing import NamedTuple

_ROOT = Path(__file__).parents[1]
_COPIED = ("narx", "baselines", "experiments", "configs", "tests", "docs")
_FILES = ("pyproject.toml", "README.md")
# slow to import; nothing of the package itself, which each child imports from the copy
LIBRARIES = (
    "torch", "scipy.stats", "scipy.signal", "pandas", "numba", "hydra", "hypothesis", "pytest",
)  # fmt: skip
NOT_NOTICED, NOTICED = 0, 1  # exit statuses of pytest: all passed, some failed
# a change may make a loop endless or an array huge
_LONGEST_S, _MOST_BYTES = 300, 8 << 30


class Change(NamedTuple):
    """One changed line.

    Parameters
    ----------
    what : str
        Description.
    file : str
        File, relative to the project.
    original, changed : str
        Text that occurs once in the file, and what replaces it.
    tests : tuple of str
        Test files or single tests of which at least one must fail.
    """

    what: str
    file: str
    original: str
    changed: str
    tests: tuple[str, ...]


def table() -> list[Change]:
    """Read the table."""
    content = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    return [Change(**{**entry, "tests": tuple(entry["tests"])}) for entry in content["change"]]


def copied_package(folder: Path) -> Path:
    """Copy what the tests need."""
    # what numba has compiled goes along, its stamp is of the content
    ignored = shutil.ignore_patterns("*.pyc")
    for name in _COPIED:
        shutil.copytree(_ROOT / name, folder / name, symlinks=True, ignore=ignored)
    for name in _FILES:
        shutil.copy(_ROOT / name, folder)
    return folder


def status_of_tests(change: Change, package: Path) -> int:
    """Change the copy, run the tests in a child process, and change it back.

    Returns the exit status of pytest, or the negative number of the signal that stopped it.
    """
    path = package / change.file
    source = path.read_text(encoding="utf-8")
    if source.count(change.original) != 1:
        raise ValueError(
            f"{change.file}: {change.original!r} occurs {source.count(change.original)} times, "
            "expected once"
        )
    path.write_text(source.replace(change.original, change.changed), encoding="utf-8")
    try:
        child = os.fork()
        if not child:
            _run_tests(change, package)
        _, status = os.waitpid(child, 0)
    finally:
        path.write_text(source, encoding="utf-8")
    return os.waitstatus_to_exitcode(status)


def _run_tests(change: Change, package: Path) -> None:
    import resource  # as fork, not on every system

    signal.alarm(_LONGEST_S)
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_BYTES, _MOST_BYTES))
    os.chdir(package)
    sys.path.insert(0, str(package))
    sys.dont_write_bytecode = True
    log = os.open(package / "pytest.log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(log, 1)
    os.dup2(log, 2)
    import pytest

    gc.freeze()  # pytest collects garbage at its end, not that of the libraries
    status = 70  # an internal error, unless pytest returns
    try:
        # pytest warns of hypothesis, whose asserts it would rewrite for seconds
        options = ["-x", "-q", "-p", "no:cacheprovider", "-W", "ignore:Module already imported"]
        status = int(pytest.main([*options, *change.tests]))
        sys.stdout.flush()
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(status)


def main(words: list[str]) -> int:
    """Run the entries that contain one of the words, all without any; count those missed."""
    changes = [c for c in table() if not words or any(w in f"{c.what} {c.file}" for w in words)]
    for library in LIBRARIES:
        importlib.import_module(library)
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        package = copied_package(Path(folder))
        for change in changes:
            status = status_of_tests(change, package)
            answer = {NOTICED: "noticed", NOT_NOTICED: "NOT NOTICED"}.get(status, f"exit {status}")
            missed += status != NOTICED
            print(f"{answer:12} {change.file}: {change.what}", flush=True)
            if status not in (NOTICED, NOT_NOTICED):
                print((package / "pytest.log").read_text(encoding="utf-8")[-3000:])
    print(f"{len(changes) - missed} of {len(changes)} changes noticed")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
