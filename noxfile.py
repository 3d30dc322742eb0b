"""Tests with other Python versions and dependencies, and the release: ``nox --list``.

Continuous integration runs `make test` with one Python version; `nox -s tests` takes an hour.
"""

import re
import tempfile
import tomllib
from pathlib import Path

import nox

nox.options.sessions = ["tests"]
nox.options.error_on_missing_interpreters = False

_PROJECT = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["project"]
_EXTRAS = ("dev", "filters", "onnx", "sweep")
# what a user does first
_FIRST_STEPS = (
    "import narx, numpy as np; from narx.inference.pretrained import pretrained; "
    "trial = narx.SimulatedGait(subjects=['S1'], conditions=['slow'], treadmill_duration_s=20.0)"
    ".load('S1', 'slow', '1'); "
    "angles = narx.predict(trial.imus['thigh_right'], pretrained().method()).angles_rad; "
    "assert np.isfinite(angles).any(); print(angles.shape)"
)


@nox.session(python=["3.11", "3.12", "3.13"])
def tests(session: nox.Session) -> None:
    """Run the tests with the pinned dependencies."""
    # torch goes first: with it installed, no other package can ask for another build
    session.install("--constraint", "constraints.txt", "torch")
    session.install("--constraint", "constraints.txt", "--editable", f".[{','.join(_EXTRAS)}]")
    session.run("pytest", "-n", "2", "--dist", "worksteal", *session.posargs)


@nox.session(python="3.11")
def oldest(session: nox.Session) -> None:
    """Run the tests with the oldest version of every dependency that pyproject.toml allows."""
    requirements = _PROJECT["dependencies"] + _PROJECT["optional-dependencies"]["filters"]
    pinned = [line for r in requirements if (line := oldest_version(r))]
    torch = next(line for line in pinned if line.startswith("torch"))
    session.install(torch)
    session.install(*pinned)
    session.install("pytest", "pytest-xdist", "hypothesis", "ahrs", "numpydoc", "vqf")
    session.install("--no-deps", "--editable", ".")
    session.run("pytest", "-n", "2", "--dist", "worksteal", *session.posargs)


def oldest_version(requirement: str) -> str:
    """Turn the lower bound of a requirement into an exact version; empty without a bound."""
    found = re.match(r"([\w.\[\]-]+)>=([\w.]+)", requirement)
    return f"{found[1]}=={found[2]}" if found else ""


@nox.session(python="3.11")
def release(session: nox.Session) -> None:
    """Build sdist and wheel from the committed files, check them, install and use each."""
    session.install("build", "twine")
    with tempfile.TemporaryDirectory() as folder:
        source, built = Path(folder, "source"), Path("dist").resolve()
        session.run("git", "diff", "--exit-code", "--stat", "HEAD", external=True)
        session.run("git", "clone", "--quiet", ".", str(source), external=True)
        session.run("python", "-m", "build", "--outdir", str(built), str(source))
        version = _PROJECT["version"]
        files = sorted(map(str, built.glob(f"narx_orientation-{version}*")))
        if len(files) != 2:
            session.error(f"{built}: {len(files)} files of version {version}, expected two")
        session.run("twine", "check", "--strict", *files)
        for file in files:
            session.install("--constraint", "constraints.txt", "torch")
            session.install("--force-reinstall", "--no-deps", file)
            session.install("--constraint", "constraints.txt", file)
            with session.chdir(folder):  # not the checkout
                session.run("python", "-c", _FIRST_STEPS)
                session.run("narx-predict", "--help", silent=True)


@nox.session(python="3.11")
def audit(session: nox.Session) -> None:
    """Look for known vulnerabilities in the pinned dependencies (needs the advisory database)."""
    session.install("pip-audit")
    session.run("pip-audit", "--requirement", "constraints.txt", "--no-deps", "--disable-pip")
