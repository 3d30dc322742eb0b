"""A damaged text file is refused with the position of the damage, not read in part."""

import numpy as np
import pytest

from narx.datasets.text_table import read_numbers
from narx.errors import RecordingError


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "table.txt"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_numbers_are_read_as_written(written):
    rng = np.random.default_rng(0)
    values = rng.normal(size=(20, 4)) * 10.0 ** rng.integers(-8, 8, size=(20, 4))
    path = written("\n".join(" ".join(map(repr, map(float, row))) for row in values) + "\n")
    assert (read_numbers(path) == values).all()
    assert (read_numbers(path, columns=2) == values[:, :2]).all()


def test_named_columns_in_the_order_asked_for(written):
    path = written("// made up\n// twice\nb, a,c\n1,2,x\n3,4,\n")
    table = read_numbers(path, separator=",", columns=["a", "b"], comment="//")
    assert table.tolist() == [[2, 1], [4, 3]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n4 5\n", "line 2 has 2 values, expected 3"),
        ("1 2 3\n4 5 6 7\n", "line 2 has 4 values, expected 3"),
        ("1 2 3\n4 5 oops\n", "line 2, column 3: found 'oops'"),
        ("1 2 3\n4 nan 6\n", "line 2, column 2: found 'nan'"),
        ("1 2 3\n4 5 inf\n", "line 2, column 3: found 'inf'"),
        ("1 2 3\n4 5 -1e200\n", "column 3: found '-1e200', expected a number of at most 1e\\+100"),
        ("1 2 3\n4 5 6", "line 2 is the last and has no line break"),
        ("1 2\n", "line 1 has 2 columns, expected at least 3"),
        ("", "no data lines"),
    ],
)
def test_damage_is_named_with_its_place(written, text, message):
    with pytest.raises(RecordingError, match=message) as caught:
        read_numbers(written(text), columns=3, terminated=True)
    assert "\n" not in str(caught.value)
    assert "table.txt" in str(caught.value)


def test_missing_column_and_missing_file(written, tmp_path):
    with pytest.raises(RecordingError, match="no column 'c' in the header; found a, b"):
        read_numbers(written("a,b\n1,2\n"), separator=",", columns=["c"])
    with pytest.raises(RecordingError, match="no such file"):
        read_numbers(tmp_path / "nowhere.txt")
    with pytest.raises(RecordingError, match="no data lines"):
        read_numbers(written("a,b\n"), separator=",", columns=["a"])


def test_missing_values_where_they_are_allowed(written):
    path = written("a,b\n1,\nNaN,4\n")
    table = read_numbers(path, separator=",", columns=["a", "b"], missing_allowed=True)
    assert np.array_equal(table, [[1, np.nan], [np.nan, 4]], equal_nan=True)


def test_not_text(tmp_path):
    path = tmp_path / "binary.txt"
    path.write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(RecordingError, match="cannot be read as text"):
        read_numbers(path)
