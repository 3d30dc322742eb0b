"""Compiled code on disk is never stale, and an unusable cache is not an error."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.concurrency

ROOT = Path(__file__).resolve().parents[3]

STRIDE = """
import sys, warnings
warnings.simplefilter("always")
import numpy as np
from narx.kernels.stride import track_all
constants = 0.01, 0.2, 0.003, 0.5, 2.5, 0.3
rates = 3.0 * np.sin(2 * np.pi * 0.9 * np.arange(400) / 100)
out = track_all(rates, (0.0, 0.0, 1.0, np.inf, False, False), constants)
print(len(track_all.stats.cache_hits), round(float(out[-1]), 6))
"""


@pytest.fixture(scope="module")
def compiled_package(tmp_path_factory):
    """A copy of the package with one function compiled, and what that returns."""
    package = tmp_path_factory.mktemp("compiled")
    for folder in ("narx", "baselines", "experiments", "configs"):
        shutil.copytree(
            ROOT / folder, package / folder, symlinks=True,
            ignore=shutil.ignore_patterns("__pycache__", "*.pt"),
        )  # fmt: skip
    hits, expected = hits_and_result(run(package))
    assert hits == 0
    return package, expected


@pytest.fixture
def expected(compiled_package):
    return compiled_package[1]


@pytest.fixture
def package(compiled_package, tmp_path):
    """A private copy of the package for one test."""
    return Path(shutil.copytree(compiled_package[0], tmp_path / "package", symlinks=True))


def run(package, script=STRIDE, **environment):
    inherited = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
    return subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, cwd=package,
        env={**inherited, "PYTHONPATH": str(package), "PYTHONDONTWRITEBYTECODE": "1"}
        | environment,
    )  # fmt: skip


def hits_and_result(answer):
    assert answer.returncode == 0, answer.stderr
    hits, result = answer.stdout.split()
    return int(hits), float(result)


def nothing_can_be_written(package):
    """Put files where directories would be created, which fails for every user, root included."""
    (package / "narx/kernels/__pycache__").write_text("")
    return {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null"}


def test_an_edited_helper_is_compiled_anew(package, expected):
    assert hits_and_result(run(package)) == (1, expected)
    helper = package / "narx/kernels/stride.py"
    before = helper.stat()
    text = helper.read_text()
    assert "weight = smoothing if seen else 1.0" in text
    helper.write_text(text.replace("smoothing if seen else 1.0", "smoothing if seen else 0.5"))
    os.utime(helper, ns=(before.st_atime_ns, before.st_mtime_ns))
    hits, changed = hits_and_result(run(package))
    assert hits == 0
    assert changed != expected


def test_compiling_is_logged_when_it_happens(package):
    script = "import logging; logging.basicConfig(level=logging.INFO)" + STRIDE
    assert "compiling" not in run(package, script).stderr
    with (package / "narx/kernels/stride.py").open("a") as source:
        source.write("# edited\n")
    assert run(package, script).stderr.count("compiling") == 1


def test_an_edit_of_any_other_file_of_the_folder_counts_as_well(package, expected):
    limits = package / "narx/kernels/limits.py"
    limits.write_text(limits.read_text().replace("0.1", "0.2"))
    assert hits_and_result(run(package)) == (0, expected)


def test_compiles_in_memory_where_nothing_can_be_written(package, expected):
    shutil.rmtree(package / "narx/kernels/__pycache__")
    closed = nothing_can_be_written(package)
    answer = run(package, **closed)
    assert hits_and_result(answer) == (0, expected)
    assert answer.stderr.count("RuntimeWarning") == 1
    assert "NUMBA_CACHE_DIR" in answer.stderr
    # another unwritable folder changes nothing; a writable one is used
    answer = run(package, **closed, NUMBA_CACHE_DIR="/dev/null/cache")
    assert hits_and_result(answer) == (0, expected)
    assert answer.stderr.count("RuntimeWarning") == 1
    opened = {**closed, "NUMBA_CACHE_DIR": str(package / "cache")}
    for hits in (0, 1):
        answer = run(package, **opened)
        assert hits_and_result(answer) == (hits, expected)
        assert not answer.stderr


def test_a_full_disk_is_no_reason_to_fail(package):
    # the folder exists at import, but writing files to it fails later
    full = "import builtins, errno, numba.core.caching as caching\n" + (
        "def refuse(self, name, data):\n"
        "    raise OSError(errno.ENOSPC, 'No space left on device')\n"
        "caching.IndexDataCacheFile._save_data = refuse\n"
    )
    expected = hits_and_result(run(package))[1]
    shutil.rmtree(package / "narx/kernels/__pycache__")
    answer = run(package, full + STRIDE)
    assert hits_and_result(answer) == (0, expected)
    assert answer.stderr.count("RuntimeWarning") == 1
    assert "NUMBA_CACHE_DIR" in answer.stderr


@pytest.mark.parametrize("kind", ["*.nbc", "*.nbi"])
@pytest.mark.parametrize("damage", ["empty", "half", "flipped", "garbage"])
def test_a_damaged_cache_is_compiled_anew(package, expected, kind, damage):
    folder = package / "narx/kernels/__pycache__"
    (path,) = folder.glob(f"stride.{kind}")
    content = path.read_bytes()
    middle = len(content) // 2
    path.write_bytes(
        {
            "empty": b"",
            "half": content[:middle],
            "flipped": content[:middle] + bytes([content[middle] ^ 0xFF]) + content[middle + 1 :],
            "garbage": b"\x93garbage" * 50,
        }[damage]
    )
    answer = run(package)
    hits, result = hits_and_result(answer)
    assert result == expected
    assert not answer.stderr
    if damage != "flipped":  # a byte that does not matter may leave an index readable
        assert hits == 0


def test_compiled_functions_live_in_the_kernels_folder():
    for folder in ("narx", "baselines", "experiments"):
        for path in (ROOT / folder).rglob("*.py"):
            if path.parent.name == "kernels" or path.parent.is_symlink():
                continue
            text = path.read_text()
            assert "import numba" not in text, path
            assert "from numba" not in text, path
            assert "kernels.compiler import" not in text, path


def test_kernels_take_nothing_from_the_rest_of_the_package():
    for path in (ROOT / "narx/kernels").glob("*.py"):
        for line in path.read_text().splitlines():
            words = line.split()
            if words[:1] in (["from"], ["import"]) and words[1].startswith("narx"):
                assert words[1].startswith("narx.kernels"), f"{path.name}: {line}"


def test_numbas_inside_is_used_in_one_file():
    for path in (ROOT / "narx/kernels").glob("*.py"):
        if path.name != "numba_internals.py":
            text = path.read_text()
            for name in ("numba.core", "numba.extending", "llvmlite", "from numba"):
                assert name not in text, path
