"""What is done about a gap is what is said about it."""

import re

import numpy as np
import pytest

from narx.inference.findings import gap_notes
from narx.recordings.gaps import gaps_of, on_clock
from narx.recordings.trial import ImuRecording

RATE_HZ = 100.0


def holed(seconds, gap_s):
    time_s = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    values = np.sin(2 * np.pi * time_s)[:, None] * [1.0, 0.5, 0.2]
    begin = len(time_s) // 2
    values[begin + 1 : begin + round(gap_s * RATE_HZ)] = np.nan
    return time_s, values


@pytest.mark.parametrize(
    ("seconds", "gap_s", "kind", "note"),
    [
        (20.0, 0.02, "interpolated", "1 gap of up to 0.02 s interpolated"),
        (20.0, 0.05, "interpolated", "1 gap of up to 0.05 s interpolated"),
        (20.0, 0.1, "interpolated", "1 gap of up to 0.1 s interpolated"),
        (20.0, 0.15, "filled", "1 gap of up to 0.15 s filled from the rhythm"),
        (20.0, 0.5, "filled", "1 gap of up to 0.5 s filled from the rhythm"),
        (20.0, 1.5, "left", "1 gap longer than 1.1 s .* the network pauses there"),
        (3.5, 0.5, "left", "1 gap in a recording too short to fill them .* the network pauses"),
    ],
)
def test_the_note_is_true(seconds, gap_s, kind, note):
    time_s, values = holed(seconds, gap_s)
    gaps = gaps_of(time_s, values, 1.1)
    kinds = ("interpolated", "filled", "left")
    assert [name for name in kinds for _ in range(getattr(gaps, name).sum())] == [kind]
    there = np.isfinite(on_clock(time_s, values, time_s, RATE_HZ, 1.1)).all()
    assert there == (kind != "left")
    (said,) = gap_notes(ImuRecording("leg", time_s, values, np.full_like(values, np.nan)), 1.1)
    assert re.match(note, said), said


def test_a_gap_begins_with_the_sample_before_it_and_the_longest_is_filled():
    """The gap of 1.1 s is the longest allowed, wherever the digits of its stamps round it to."""
    for begin in range(600, 1400, 7):
        time_s = np.arange(2000) / RATE_HZ
        values = np.sin(2 * np.pi * time_s)[:, None] * [1.0, 0.5, 0.2]
        values[begin + 1 : begin + 110] = np.nan
        gaps = gaps_of(time_s, values, 1.1)
        assert gaps.begins_s[gaps.filled].tolist() == [time_s[begin]]
        assert not gaps.left.any()
