"""The programs in docs/device run the exported files as the package's stream does, without it."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from narx.export import read_identity, verification, write
from narx.inference.pretrained import pretrained
from narx.inference.stream import OrientationStream

EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "device"


@pytest.fixture(scope="module")
def walk():
    """Rows of interval and rates of a walk with lost samples and packets, and what is expected."""
    rng = np.random.default_rng(4)
    rates = verification.walk(np.arange(1500) / 100.0)[:, :3]
    interval_s = 0.01 * np.where(rng.random(1500) < 0.01, rng.integers(2, 12, 1500), 1)
    rates[rng.random(1500) < 0.02] = np.nan
    stream = OrientationStream(pretrained().method(), 100.0)
    estimate = stream.update_block(rates, np.cumsum(interval_s))
    rows = np.column_stack([interval_s, rates])
    text = "\n".join(",".join(f"{value:.17g}" for value in row) for row in rows)
    assert estimate.std_rad is not None
    wanted = np.column_stack([estimate.angles_rad, estimate.std_rad, estimate.quality])
    return text, wanted


def run(command, folder, walk, atol_rad=1e-9):
    text, wanted = walk
    done = subprocess.run(
        command, cwd=folder, input=text, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    found = np.array([row.split(",") for row in done.stdout.split()]).astype(float)
    there = wanted[:, 6] != 2
    np.testing.assert_allclose(found[:, :3], wanted[:, :3], atol=atol_rad, rtol=0)
    np.testing.assert_allclose(found[there, 3:6], wanted[there, 3:6], rtol=1e4 * atol_rad)
    np.testing.assert_array_equal(found[:, 6], wanted[:, 6])


def test_c(walk, tmp_path):
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    for precision, atol_rad in (("double", 1e-9), ("float", 1e-4)):
        write(pretrained(), tmp_path / "narx.c", "c", precision, verify=False)
        command = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-I.", EXAMPLES / "run.c"]
        subprocess.run([*command, "narx.c", "-o", "run", "-lm"], cwd=tmp_path, check=True)
        run(["./run"], tmp_path, walk, atol_rad)
    for row in ("0.01,1,2", "0.01,1,2,3,4", "0.01,1,2,x", "0.01,1,2,3x", "", "time,x,y,z"):
        rows = f"0.01,1,2,3\r\n0.01,nan,inf,-inf\n{row}\n"
        refused = subprocess.run(
            ["./run"], cwd=tmp_path, input=rows, capture_output=True, text=True, check=False
        )
        assert refused.returncode == 1
        assert refused.stderr.startswith("line 3: expected four numbers")
        assert len(refused.stdout.splitlines()) == 2


@pytest.mark.slow
def test_libtorch(walk, tmp_path):
    if shutil.which("g++") is None:
        pytest.skip("no g++")
    write(pretrained(), tmp_path / "narx.pt", verify=False)
    root = Path(torch.__path__[0])
    include, lib = root / "include", root / "lib"
    if not (include / "torch" / "script.h").is_file():
        pytest.skip("torch was installed without its headers")
    command = [
        "g++", "-std=c++20", "-O1", EXAMPLES / "run.cpp", f"-I{include}",
        f"-I{include / 'torch/csrc/api/include'}", f"-L{lib}", f"-Wl,-rpath,{lib}",
        "-ltorch", "-ltorch_cpu", "-lc10", "-o", "run",
    ]  # fmt: skip
    subprocess.run(command, cwd=tmp_path, check=True)
    run(["./run", "narx.pt"], tmp_path, walk)


@pytest.fixture(scope="module")
def onnx_file(tmp_path_factory):
    for library in ("onnx", "onnxscript", "onnxruntime"):
        pytest.importorskip(library)
    path = tmp_path_factory.mktemp("onnx") / "narx.onnx"
    write(pretrained(), path, "onnx", verify=False)
    path.with_suffix(".json").write_text(json.dumps(read_identity(path)))
    return path


@pytest.mark.slow
def test_onnxruntime_in_javascript(walk, onnx_file):
    if shutil.which("node") is None or shutil.which("npm") is None:
        pytest.skip("no node and npm")
    folder = onnx_file.parent
    shutil.copy(EXAMPLES / "run.mjs", folder)
    install = ["npm", "install", "--no-audit", "--no-fund", "--ignore-scripts"]
    installed = subprocess.run(
        [*install, "onnxruntime-web@1.30.0"], cwd=folder, capture_output=True, text=True,
        timeout=300, check=False,
    )  # fmt: skip
    if installed.returncode != 0:
        pytest.skip(f"npm cannot install onnxruntime-web: {installed.stderr.strip()[-200:]}")
    run(["node", "run.mjs", "narx.onnx", "narx.json"], folder, walk)


@pytest.mark.slow
def test_onnxruntime_in_python(walk, onnx_file):
    command = [sys.executable, "-I", EXAMPLES / "run_onnx.py", "narx.onnx"]
    run(command, onnx_file.parent, walk)
