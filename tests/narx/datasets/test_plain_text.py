"""The fast reader gives the same result as the general one, or leaves the file to it."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from narx.datasets.csv_recording import open_table
from narx.datasets.plain_text import plain_table
from narx.datasets.text_dialect import read_table
from narx.errors import RecordingError

PATH = Path("walk.csv")
_NUMBER = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.integers(-(10**6), 10**6).map(str),
    st.sampled_from(["", "nan", "NaN", "NA", "1e-320", "+.5", "-0", "7.", "9007199254740993"]),
)


@settings(max_examples=200, deadline=None)
@given(
    st.integers(2, 4).flatmap(
        lambda width: st.lists(
            st.lists(_NUMBER, min_size=width, max_size=width), min_size=3, max_size=12
        )
    ),
    st.sampled_from(["\n", "\r\n"]),
)
def test_the_numbers_are_the_same_to_the_last_bit(rows, line_end):
    rows = [["0.5"] * len(rows[0]), *rows]
    names = ["time_s", "a", "b (rad/s)", "c"][: len(rows[0])]
    content = line_end.join([",".join(names), *map(",".join, rows), ""]).encode()
    fast, slow = plain_table(PATH, content), read_table(PATH, content)
    if fast is None:
        return
    assert fast.names == slow.names == tuple(names)
    for k in range(len(names)):
        np.testing.assert_array_equal(fast.numbers(k), slow.numbers(k))
        np.testing.assert_array_equal(np.signbit(fast.numbers(k)), np.signbit(slow.numbers(k)))


def test_a_usual_recording_is_read_by_it():
    assert plain_table(PATH, b"time_s,x\n0,1.5\n0.01,nan\n0.02,\n") is not None


@pytest.mark.parametrize(
    "content",
    [
        b"time_s,x\n0,1\n0.01,2",  # possibly truncated
        b"time_s,x\n0,1\n0.01\n0.02,3\n",
        b"time_s;x\n0;1\n",
        b'"time_s","x"\n0,1\n',
        b"\xef\xbb\xbftime_s,x\n0,1\n",
        b"# comment\ntime_s,x\n0,1\n",
        b"time_s,x\ns,m\n0,1\n",
        b"time_s,x\n0,0x10\n",
        b"time_s,x\n0,1_0\n",
        b"time_s,x\n0,inf\n",
        b"time_s,x\n0,1e999\n",
        b"time_s,x\n0,1\r0.01,2\n",
        b"time_s,x\n0,1,\n0.01,2,\n",
        b"time_s,x\n2024-01-01,1\n",
        b"time_s,x\n",
        b"0,1\n0.01,2\n",
        b"",
    ],
)
def test_everything_else_is_left_to_the_detection_of_the_dialect(content):
    assert plain_table(PATH, content) is None


def test_a_wrong_cell_is_still_named(tmp_path):
    path = tmp_path / "walk.csv"
    path.write_text("time_s,x\n0,1\n0.01,1e999\n")
    with pytest.raises(RecordingError, match="line 3, column x: found '1e999'"):
        open_table(path).numbers(1)
