"""MATLAB files: fields by name, damage by name."""

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


def test_no_such_file(tmp_path):
    with pytest.raises(RecordingError, match="no such file"):
        read_mat(tmp_path / "nowhere.mat")
