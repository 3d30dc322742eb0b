"""The export is written completely and correctly or not at all."""

import errno
import importlib.util
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
import torch

import narx
from narx.errors import UserError
from narx.export import onnx, read_identity, torchscript, verification, write
from narx.inference import save

FILES = {
    "torchscript": ["narx.pt"],
    "torch_export": ["narx.pt2"],
    "onnx": ["narx.onnx"],
    "c": ["narx.c", "narx.h"],
}


def needs(name):
    if name == "onnx":
        for library in ("onnx", "onnxscript", "onnxruntime"):
            pytest.importorskip(library)
    if name == "c" and not any(map(shutil.which, ("cc", "gcc", "clang"))):
        pytest.skip("no C compiler")


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
@pytest.mark.parametrize(
    "name",
    [
        "torchscript",
        "c",
        *(pytest.param(n, marks=pytest.mark.slow) for n in ("torch_export", "onnx")),
    ],
)
def test_a_file_has_its_identity_but_no_paths(checkpoint, name, tmp_path, request):
    needs(name)
    about = write(checkpoint, tmp_path / FILES[name][0], name)
    assert sorted(path.name for path in tmp_path.iterdir()) == FILES[name]
    for file in FILES[name]:
        assert read_identity(tmp_path / file) == about
        content = (tmp_path / file).read_bytes()
        for folder in (str(request.config.rootpath), str(tmp_path), "site-packages", "/home"):
            assert folder.encode() not in content
    assert about["version"] == narx.__version__
    assert about["checkpoint_sha256"] == checkpoint.sha256
    assert about["precision"] == ("float" if name == "c" else "double")
    assert about["error_std_rad"] == [None, None, None]
    verified = about["verification"]
    assert 0.0 < verified["largest_difference_rad"] < verified["tolerance_rad"]


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_the_same_network_is_the_same_file(checkpoint, tmp_path):
    for name in ("a.pt", "b.pt"):
        write(checkpoint, tmp_path / name, verify=False)
    assert (tmp_path / "a.pt").read_bytes() == (tmp_path / "b.pt").read_bytes()
    assert read_identity(tmp_path / "a.pt")["verification"] is None


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_the_file_is_the_same_in_other_processes(checkpoint, tmp_path):
    save(checkpoint, tmp_path / "checkpoint.pt")
    source = "import sys; from narx.export import write; from narx.inference import load\n"
    source += "write(load(sys.argv[1]), sys.argv[2], verify=False)"
    for seed in "12":  # of the order of sets
        (tmp_path / seed).mkdir()
        command = [sys.executable, "-c", source, tmp_path / "checkpoint.pt", "narx.pt"]
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        subprocess.run(command, cwd=tmp_path / seed, env=environment, check=True)
    first, second = ((tmp_path / seed / "narx.pt").read_bytes() for seed in "12")
    assert first == second


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_a_disk_that_is_full_leaves_the_files_before(checkpoint, tmp_path, monkeypatch):
    path = tmp_path / "narx.c"
    write(checkpoint, path, "c", "float", verify=False)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    write_bytes = Path.write_bytes

    def full(file, content):
        if file.suffix == ".c":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write_bytes(file, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(UserError, match=r"cannot be written: No space left on device"):
        write(checkpoint, path, "c", "double", verify=False)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
@pytest.mark.parametrize("error_rad", [2e-9, np.nan])
def test_no_file_where_the_export_is_another_method(checkpoint, tmp_path, monkeypatch, error_rad):
    right = torchscript.loaded

    def wrong(data):
        def run(*arguments):
            angles = right(data)(*arguments)
            angles[1] += error_rad
            return angles

        return run

    monkeypatch.setattr(torchscript, "loaded", wrong)
    with pytest.raises(UserError, match=r"differs from the package by .* expected at most 1e-09"):
        write(checkpoint, tmp_path / "narx.pt")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_verification_signals_contain_losses_and_jitter(checkpoint):
    inputs, interval_s = verification.signals(checkpoint)
    rates = inputs[..., :3]
    missing = np.isnan(rates).any(axis=2)
    assert 0.01 < missing.mean() < 0.2
    # the integrated rate stays bounded, including the turn and the slip
    turned = np.nancumsum(np.where(np.abs(rates[0]) < 30.0, rates[0], np.nan), axis=0) / 25.0
    assert 0.3 < np.ptp(turned[:, 0]) < 2.0
    assert np.nanmax(rates) > 1e20
    assert np.ptp(interval_s[0]) == 0.0
    assert np.ptp(interval_s[1]) > 0.01
    # long enough for the network to run after the start-up
    assert np.isfinite(rates).all(axis=2).sum(axis=1).min() / 25.0 > 1.0 + 3.0 + 5.0


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_mistakes_are_one_line_and_leave_nothing(checkpoint, tmp_path, monkeypatch):
    for arguments, reason in (
        (("narx.m", "matlab"), "format is 'matlab', expected one of torchscript, torch_export"),
        (("narx.pt", "torchscript", "half"), "precision is 'half', expected one of double, float"),
        (("narx.txt", "c"), r"narx\.txt', expected a name ending in \.c for format=c"),
        (("narx.pt", "torch_export"), r"narx\.pt', expected a name ending in \.pt2"),
        (("narx.pt", "onnx"), r"narx\.pt', expected a name ending in \.onnx for format=onnx"),
        (("narx.pt2",), r"narx\.pt2', expected a name ending in \.pt for format=torchscript"),
    ):
        with pytest.raises(UserError, match=reason):
            write(checkpoint, tmp_path / arguments[0], *arguments[1:])
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(UserError, match=r"no C compiler \(cc, gcc, clang\).*verify=false"):
        write(checkpoint, tmp_path / "narx.c", "c")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"^format=onnx needs onnx and onnxscript.*pip install"):
        onnx.check_libraries()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("checkpoint", ["no_washout"], indirect=True)
def test_a_network_that_cannot_run_is_not_exported(checkpoint, tmp_path):
    model = checkpoint.model
    weights, rate_hz = model.weights.detach().clone(), model.sampling_rate_hz
    try:
        with torch.no_grad():
            model.weights[0] = np.nan
        with pytest.raises(UserError, match="weight of the network is not finite"):
            write(checkpoint, tmp_path / "narx.pt")
        with torch.no_grad():
            model.weights.copy_(weights)
        model.sampling_rate_hz = -100.0
        with pytest.raises(UserError, match=r"sampling_rate_hz is -100\.0"):
            write(checkpoint, tmp_path / "narx.pt")
    finally:
        model.sampling_rate_hz = rate_hz
        with torch.no_grad():
            model.weights.copy_(weights)
    assert not list(tmp_path.iterdir())


def test_another_file_has_no_identity(tmp_path):
    with pytest.raises(UserError, match="no file"):
        read_identity(tmp_path / "none.pt")
    torch.save([1], tmp_path / "other.pt")
    (tmp_path / "narx.c").write_text("int main(void) { return 0; }\n")
    (tmp_path / "narx.h").write_text('#define NARX_IDENTITY "{}"\n')
    (tmp_path / "text.h").write_text("#define OTHER\n")
    for name in ("other.pt", "narx.c", "text.h"):
        with pytest.raises(UserError, match=r"written by narx\.export|export of another program"):
            read_identity(tmp_path / name)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_what_cannot_be_written_is_one_line(checkpoint, tmp_path):
    (tmp_path / "narx.pt").mkdir()
    (tmp_path / "file").write_text("")
    for name, export_format, reason in (
        ("narx.pt", "torchscript", r"narx\.pt' is a folder"),
        ("file/narx.pt", "torchscript", r"^output: '.*narx\.pt' cannot be written: "),
        ("Math.c", "c", r"Math\.h would hide the C library's header"),
        ('a"b.c', "c", "expected a name without quotes, backslashes and control characters"),
        ("a\nb.c", "c", "expected a name without quotes"),
        ("a\\b.c", "c", "expected a name without quotes"),
        ("\udcff.c", "c", "expected a name without quotes"),
        (300 * "a" + ".c", "c", r"\.c' cannot be written: "),
    ):
        with pytest.raises(UserError, match=reason):
            write(checkpoint, tmp_path / name, export_format, verify=False)
    with pytest.raises(UserError, match="checkpoint is a str, expected a Checkpoint"):
        write("narx.pt", tmp_path / "other.pt")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "narx.pt"]


def test_a_nested_header_is_no_identity(tmp_path):
    with zipfile.ZipFile(tmp_path / "narx.pt", "w") as archive:
        archive.writestr("narx/extra/narx.json", "[" * 100_000)
    with pytest.raises(UserError, match=r"not written by narx\.export\.write"):
        read_identity(tmp_path / "narx.pt")
