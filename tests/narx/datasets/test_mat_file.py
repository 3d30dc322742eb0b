"""MATLAB files: fields are found by name, and errors name the damaged field."""

import struct
import tracemalloc
import zlib

import numpy as np
import pytest
import scipy.io

from narx.datasets.mat_file import numeric_field, read_mat
from narx.errors import RecordingError


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "made.mat"
    inner = {"values": np.arange(6000.0).reshape(3, 2000), "label": "text"}
    scipy.io.savemat(path, {"outer": {"inner": inner}, "rate": 60.0})
    return path


def test_fields_are_found_by_their_path(path):
    variables = read_mat(path)
    assert set(variables) == {"outer", "rate"}
    values = numeric_field(path, variables, "outer.inner.values")
    assert (values == np.arange(6000.0).reshape(3, 2000)).all()
    assert numeric_field(path, variables, "rate") == 60.0


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("inner", "no variable 'inner'; found outer, rate"),
        ("outer.inner.missing", "no field 'outer.inner.missing'.*found values, label"),
        ("rate.deeper", "no field 'rate.deeper'"),
        ("outer.inner.label", "not numeric"),
    ],
)
def test_missing_fields_are_named(path, name, message):
    with pytest.raises(RecordingError, match=message):
        numeric_field(path, read_mat(path), name)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.5, 0.999])
def test_a_file_cut_off_anywhere_is_refused_in_one_line(path, share):
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(RecordingError, match="not a whole MATLAB file") as caught:
        read_mat(path)
    assert "\n" not in str(caught.value)
    assert "made.mat" in str(caught.value)


@pytest.mark.parametrize("compressed", [False, True])
def test_no_damaged_tag_reaches_the_compiled_reader(tmp_path, compressed):
    """scipy takes an element's type as an index, and a wrong one ends the process."""
    path = tmp_path / "made.mat"
    cells = np.array([np.arange(3.0), "text"], dtype=object)
    scipy.io.savemat(path, {"outer": {"values": np.eye(3), "cells": cells}})
    whole = path.read_bytes()
    refused = 0
    for at in range(128, len(whole) - 3, 4):
        damaged = whole[:at] + struct.pack("<I", 0x7654) + whole[at + 4 :]
        if compressed:
            packed = zlib.compress(damaged[128:])
            damaged = damaged[:128] + struct.pack("<II", 15, len(packed)) + packed
        path.write_bytes(damaged)
        try:
            read_mat(path)
        except RecordingError as error:
            refused += "unknown type" in str(error)
    # outer, its struct's two fields, the two cells: each of five tags or more
    assert refused > 20


def test_variables_nested_without_end_are_refused(tmp_path):
    path = tmp_path / "made.mat"
    scipy.io.savemat(path, {"rate": 1.0})
    header = path.read_bytes()[:128]
    nested = b""
    for _ in range(2000):
        nested = struct.pack("<II", 14, len(nested)) + nested
    path.write_bytes(header + nested)
    with pytest.raises(RecordingError, match="nested more than 32 deep"):
        read_mat(path)


@pytest.mark.parametrize("number", [1e200, -1e200, np.inf, -np.inf])
def test_an_exponent_that_was_hit_is_refused(tmp_path, number):
    path = tmp_path / "made.mat"
    scipy.io.savemat(path, {"rate": [1.0, number, np.nan]})
    with pytest.raises(
        RecordingError, match=r"made.mat: field 'rate' has a number of size (1e\+200|inf)"
    ):
        numeric_field(path, read_mat(path), "rate")


def test_a_signalling_nan_is_a_missing_number(tmp_path):
    path = tmp_path / "made.mat"
    signalling = np.array([0x7FF0_0000_0000_0001, 0x3FF0_0000_0000_0000], dtype="<u8")
    scipy.io.savemat(path, {"rate": signalling.view("<f8")})
    rate = numeric_field(path, read_mat(path), "rate")
    np.testing.assert_array_equal(rate - 1.0, [np.nan, 0.0])  # warnings are errors here


def test_no_such_file(tmp_path):
    with pytest.raises(RecordingError, match="no such file"):
        read_mat(tmp_path / "nowhere.mat")


def test_a_small_file_that_asks_for_gigabytes_is_refused(tmp_path):
    """Zeros compress a thousandfold; this writes 600 MB of them without holding them in memory."""
    path = tmp_path / "bomb.mat"
    packer = zlib.compressobj(9)
    zeros, n = bytes(2**20), 600
    packed = packer.compress(struct.pack("<II", 14, n * len(zeros)))
    packed += b"".join(packer.compress(zeros) for _ in range(n)) + packer.flush()
    header = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM"
    path.write_bytes(header + struct.pack("<II", 15, len(packed)) + packed)
    assert path.stat().st_size < 2**20
    tracemalloc.start()
    with pytest.raises(RecordingError, match=r"bomb\.mat: needs .* the limit of 4096 MiB"):
        read_mat(path)
    assert tracemalloc.get_traced_memory()[1] < 2**24
    tracemalloc.stop()


def test_the_limit_can_be_raised(path, monkeypatch):
    monkeypatch.setenv("NARX_MAX_MEMORY_MIB", "0.01")
    scipy.io.savemat(path, {"a": np.zeros(100_000)}, do_compression=True)
    with pytest.raises(RecordingError, match="NARX_MAX_MEMORY_MIB"):
        read_mat(path)
    monkeypatch.setenv("NARX_MAX_MEMORY_MIB", "10")
    assert read_mat(path)["a"].shape == (100_000,)
