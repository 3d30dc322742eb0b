"""Times of day by hand: half days, midnights, minutes of an hour."""

import numpy as np
import pytest

from narx.datasets.calendar_times import seconds_of

HOUR_S = 3600.0


@pytest.mark.parametrize(
    ("cells", "seconds"),
    [
        (["10:59:59.5", "11:00:00.5", "11:01:00.5"], [0.0, 1.0, 61.0]),
        (["12:59:59 PM", "1:00:00 PM", "2:00:00 PM"], [0.0, 1.0, HOUR_S + 1.0]),
        (["11:59:59 PM", "12:00:00 AM", "12:00:01 a.m."], [0.0, 1.0, 2.0]),
        (["11:59:59 AM", "12:00:01 PM"], [0.0, 2.0]),
        # two midnights, passed by jumps of 21 hours back
        (
            ["22:00:00", "01:00:00", "22:00:00", "01:00:00"],
            [0.0, 3.0 * HOUR_S, 24.0 * HOUR_S, 27.0 * HOUR_S],
        ),
        # a clock that is set back by an hour has not passed a midnight
        (["10:00:00", "09:00:00"], [0.0, -HOUR_S]),
        (["07:59.5", "08:00,5", "09:00.5"], [0.0, 1.0, 61.0]),
        (["10:00:00:250", "10:00:00:500"], [0.0, 0.25]),
        (["2026-03-01T23:59:59Z", "2026-03-02T00:00:01Z"], [0.0, 2.0]),
    ],
)
def test_seconds_since_the_first(cells, seconds):
    np.testing.assert_allclose(seconds_of(cells), seconds, atol=1e-9)


def test_a_date_that_changes_without_a_midnight_is_no_time():
    found = seconds_of(["1/2 10:00:00", "1/3 10:00:01", "1/3 10:00:02"])
    assert np.isnan(found[1])
    assert np.isfinite(found[[0, 2]]).all()
