from collections import Counter

import numpy as np
import pytest

from narx import baselines
from narx.baselines.operation_count import (
    OPERATIONS,
    CountedFloat,
    count_stream,
    count_two_point,
    operation_table,
)
from narx.errors import MethodNotApplicableError
from narx.kernels.gravity import tilt
from narx.kinematics.segment_angles import FRONTAL, tilt_from_specific_force

METHODS = {getattr(baselines, name).name: getattr(baselines, name) for name in baselines.__all__}


def test_a_counted_float_counts_and_calculates():
    counts = Counter()
    a, b = CountedFloat(3.0, counts), CountedFloat(-4.0, counts)
    result = np.sqrt(a * a + b * b) - 1.0
    assert float(result) == 4.0
    assert counts == {"multiplications": 2, "additions": 2, "roots": 1}
    assert float(np.arctan2(a, abs(b))) == pytest.approx(np.arctan2(3.0, 4.0))
    assert float(1.0 / a + 2.0 * b - (1.0 - a)) == pytest.approx(1 / 3 - 8 + 2)
    assert a > b
    assert not a <= b
    assert a <= 3.0 <= a
    assert max(a, 1.0) is a
    assert counts["divisions"] == 1
    assert counts["arctangents"] == 1
    assert counts["comparisons"] == 5
    before = counts.copy()
    # a change of sign is not an operation
    assert (float(-a), float(abs(b))) == (-3.0, 4.0)
    assert counts == before


@pytest.fixture
def walk(motion):
    return motion("walking", 100.0, 8.0).signals


def test_plain_integration_is_one_multiplication_and_two_additions_an_angle(walk):
    counts = count_stream(METHODS["gyro_integration"](), walk)
    assert counts == {**dict.fromkeys(OPERATIONS, 0.0), "additions": 6.0, "multiplications": 3.0}


def test_the_complementary_filter_takes_an_arctangent_every_sample(walk):
    method = METHODS["complementary_filter"](axes=["sagittal"], rule="rectangle")
    counts = count_stream(method, walk)
    assert counts["arctangents"] == 1.0
    # alpha (p + v T) + (1 - alpha) a is p + v T + (1 - alpha) (a - p - v T)
    assert (counts["additions"], counts["multiplications"]) == (3.0, 2.0)


def test_giof_takes_an_arctangent_only_at_rest(walk, motion):
    method = METHODS["giof"](mode="real_time", axes=["sagittal"], rest_s=0.0, low_pass_hz=None)
    walking = count_stream(method, walk)
    assert 0.0 < walking["arctangents"] < 0.2
    still = count_stream(method, motion("still", 100.0, 2.0).signals)
    assert still["arctangents"] == 1.0
    # the squared norm costs three multiplications and two additions, integrating one and two
    assert walking["multiplications"] == pytest.approx(4.0 - walking["arctangents"])
    assert still["multiplications"] == 3.0


def test_two_point_needs_less_than_the_paper_says_and_four_arctangents_a_walk(walk):
    counts = count_two_point(walk)
    n_angles = 3 * walk.n_samples
    assert counts["arctangents"] * n_angles == 4.0
    assert counts["additions"] == pytest.approx(3.0, abs=0.1)
    assert counts["multiplications"] == pytest.approx(3.0, abs=0.1)


def test_methods_that_cannot_be_counted_are_missing_not_zero(walk):
    pytest.importorskip("vqf")
    with pytest.raises(MethodNotApplicableError, match="in a compiled library"):
        count_stream(METHODS["vqf"](), walk)
    with pytest.raises(MethodNotApplicableError, match="does not run sample by sample"):
        count_stream(METHODS["two_point"](), walk)
    table = operation_table(
        walk, {name: METHODS[name]() for name in ("vqf", "two_point", "gyro_integration")}
    )
    assert list(table.columns) == list(OPERATIONS)
    assert table.loc["vqf"].isna().all()
    assert table.loc[["two_point", "gyro_integration"]].notna().all().all()


def test_counting_does_not_change_the_numbers(walk):
    method = METHODS["pseudo_integrator"](frequency="following")
    counts = Counter()
    plain, counting = method._step(100.0, None), method._step(100.0, None)
    for k in range(300):
        rates, force = walk.axis_rates_rad_s[k], walk.specific_force_m_s2[k]
        wrapped = np.array([CountedFloat(float(rate), counts) for rate in rates], dtype=object)
        np.testing.assert_array_equal(counting(wrapped, force).astype(float), plain(rates, force))


def test_tilt_of_one_sample_is_the_packages_tilt():
    force = np.random.default_rng(5).normal(size=(50, 3))
    expected = tilt_from_specific_force(force)
    for axis in (0, 1):
        np.testing.assert_allclose(
            [tilt(axis == FRONTAL, *f) for f in force], expected[:, axis], atol=1e-15
        )
