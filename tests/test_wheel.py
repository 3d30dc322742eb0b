"""The wheel, built from the tracked files and installed apart from the checkout, works."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

ROOT = Path(__file__).resolve().parents[1]
COMMANDS = ("narx-train", "narx-benchmark", "narx-predict", "narx-export")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    copy, folder = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    files = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split("\0")
    for name in filter(None, files):
        if (ROOT / name).exists():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, copy / name, follow_symlinks=False)
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", folder, copy],
        check=True,
    )
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """Folder of the commands of an environment with the wheel and its dependencies alone."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    site = Path(sysconfig.get_path("purelib", "venv", {"base": str(folder)}))
    subprocess.run(
        [
            sys.executable, "-m", "pip", "--python", folder / "bin" / "python",
            "install", "--quiet", "--no-deps", wheel,
        ],
        check=True,
    )  # fmt: skip
    # dependencies are taken from the environment of the tests; its own link to the checkout is
    # a .pth file, which is not followed from here
    (site / "dependencies.pth").write_text("\n".join(p for p in sys.path if "site-packages" in p))
    return folder / "bin"


def run(installed, cwd, command, *arguments):
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    return subprocess.run(
        [installed / command, *arguments], cwd=cwd, env=environment, capture_output=True, text=True
    )


def test_nothing_bare_lies_beside_other_peoples_packages(wheel):
    tops = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"narx"}


def test_everything_tracked_is_in_the_wheel(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    for folder in ("narx", "baselines", "experiments", "configs"):
        prefix = "" if folder == "narx" else "narx/"
        for path in (ROOT / folder).rglob("*"):
            if path.is_file() and path.suffix in (".py", ".yaml", ".csv", ".pt", ".c", ".h"):
                assert prefix + path.relative_to(ROOT).as_posix() in names


def test_angles_of_a_recording_beside_folders_of_the_same_names(installed, tmp_path):
    for folder in ("experiments", "baselines", "configs"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "__init__.py").write_text("raise ImportError('a folder of the user')")
    time_s = np.arange(0.0, 20.0, 0.02)
    swing = np.where(time_s < 4.0, 0.0, 2.0 * np.sin(2.0 * np.pi * 0.9 * time_s))
    columns = {"time_s": time_s, "gyroscope_x_rad_s": 0.0, "gyroscope_y_rad_s": -swing}
    pd.DataFrame({**columns, "gyroscope_z_rad_s": 0.0}).to_csv(tmp_path / "walk.csv", index=False)
    answer = run(installed, tmp_path, "narx-predict", "input=walk.csv", "output=angles.csv")
    assert answer.returncode == 0, answer.stderr
    angles = pd.read_csv(tmp_path / "angles.csv")
    assert np.ptp(angles["sagittal_deg"].iloc[-100:]) == pytest.approx(
        np.degrees(4.0 / (2.0 * np.pi * 0.9)), rel=0.1
    )


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_shown(installed, tmp_path, command):
    answer = run(installed, tmp_path, command, "--help")
    assert answer.returncode == 0, answer.stderr
    assert "== Keys, their defaults and meaning" in answer.stdout
