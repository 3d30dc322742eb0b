"""A message for the user is one line, whatever it quotes."""

import pickle

import pytest

from narx.errors import RecordingError, UserError


@pytest.mark.parametrize("line_break", ["\n", "\r\n", "\v", "\f", "\x1e", "\x85", "\u2028"])
def test_breaks_in_a_quoted_name_do_not_begin_a_line(line_break):
    error = RecordingError(f"walk.csv: no column 'time_s'; found a{line_break}b")
    assert str(error) == "walk.csv: no column 'time_s'; found a b"
    assert isinstance(error, UserError)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)  # as from a worker process


def test_of_a_long_quotation_the_middle_is_left_out():
    message = str(UserError("walk.csv: is " + "x" * 10**6 + ", expected a table"))
    assert message.startswith("walk.csv: is xxx")
    assert message.endswith("xxx, expected a table")
    assert " ... " in message
    assert len(message) < 2100
