"""Every unit by what it is, for instance a turn by the angles and times that make it."""

import numpy as np
import pytest

from narx.datasets.units import factor_to_si, unit_names


@pytest.mark.parametrize(
    ("quantity", "amount", "unit", "same"),
    [
        ("time", 1000, "ms", 1.0),
        ("time", 1_000_000, "µs", 1.0),
        ("time", 1_000_000_000, "nanoseconds", 1.0),
        ("time", 1, "min", 60.0),
        ("time", 1, "hours", 60.0 * 60.0),
        ("time", 1, "d", 24.0 * 3600.0),
        ("gyroscope", 360, "deg/s", 2.0 * np.pi),
        ("gyroscope", 360_000, "mdps", 2.0 * np.pi),
        ("gyroscope", 1000, "mrad/s", 1.0),
        ("gyroscope", 60, "rpm", 2.0 * np.pi),
        ("gyroscope", 1, "rev/s", 2.0 * np.pi),
        ("accelerometer", 1, "g", 9.80665),
        ("accelerometer", 1000, "mg", 9.80665),
        ("accelerometer", 980.665, "Gal", 9.80665),
        ("accelerometer", 1000, "mm/s²", 1.0),
        ("accelerometer", 1, "m s⁻²", 1.0),
        ("gyroscope", 180, "deg s-1", np.pi),
    ],
)
def test_an_amount_is_the_same_in_si(quantity, amount, unit, same):
    assert amount * factor_to_si(quantity, unit) == pytest.approx(same)
    assert amount * factor_to_si(quantity, f" [{unit}]") == pytest.approx(same)


def test_the_first_name_is_the_suffix_of_our_columns():
    assert unit_names("time")[0] == "s"
    assert unit_names("gyroscope")[:2] == ["rad_s", "deg_s"]
    assert unit_names("accelerometer")[:2] == ["m_s2", "g"]
    for quantity in ("time", "gyroscope", "accelerometer"):
        assert factor_to_si(quantity, unit_names(quantity)[0]) == 1.0
        assert factor_to_si(quantity, "furlong") is None
