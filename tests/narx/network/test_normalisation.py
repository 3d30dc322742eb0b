"""The three scalings by hand, on a signal whose mean is not zero."""

import numpy as np
import pytest

from narx.network.normalisation import Normalisation

RATES, ANGLES = np.array([1.0, 3.0, np.nan]), np.array([-1.0, 5.0])


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        # rate scale, angle scale, rate offset, angle offset
        ("min_max", (1.0, 3.0, 2.0, 2.0)),
        ("max_abs", (3.0, 5.0, 0.0, 0.0)),
        ("std", (1.0, 3.0, 0.0, 0.0)),
    ],
)
def test_offset_and_scale(kind, expected):
    found = Normalisation.fit(RATES, ANGLES, kind)
    assert (
        found.rate_scale_rad_s,
        found.angle_scale_rad,
        found.rate_offset_rad_s,
        found.angle_offset_rad,
    ) == pytest.approx(expected)
    # the reference of amplitude is a root mean square: the mean counts
    assert found.rate_rms_rad_s == pytest.approx(np.sqrt(5.0))


def test_min_max_maps_the_range_onto_one():
    found = Normalisation.fit(RATES, ANGLES, "min_max")
    ends = (ANGLES - found.angle_offset_rad) / found.angle_scale_rad
    assert ends == pytest.approx([-1.0, 1.0])


@pytest.mark.parametrize("values", [[], [2.0, 2.0], [np.nan]])
def test_what_does_not_vary_is_refused(values):
    with pytest.raises(ValueError, match="does not vary"):
        Normalisation.fit(np.array(values), ANGLES, "std")
    with pytest.raises(ValueError, match="is none of"):
        Normalisation.fit(RATES, ANGLES, "unit")


def test_the_largest_magnitude_may_be_negative():
    found = Normalisation.fit(np.array([-4.0, 1.0]), np.array([-5.0, 2.0]), "max_abs")
    assert (found.rate_scale_rad_s, found.angle_scale_rad) == (4.0, 5.0)
