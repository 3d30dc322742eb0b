"""No input, and no sequence of inputs, leaves NaN in the state of the generated C."""

import shutil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from narx.export import c
from narx.inference.pretrained import pretrained

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
NUMBERS = st.floats(width=32) | st.sampled_from([30.0, -30.0, 3e38, 1e-45, 0.0])
SAMPLES = st.lists(st.tuples(*[NUMBERS] * 4), min_size=1, max_size=40)
GOOD = np.array([0.5, -0.2, 0.1])


@pytest.fixture(scope="module")
def run():
    """The shipped network in float, compiled once."""
    return c.loaded(c.stamped(c.build(pretrained(), "float"), "narx", ""))


@given(
    samples=SAMPLES,
    pose=st.sampled_from([None, 0.0, 1000.0, 3e38, np.inf, np.nan]),
    before=st.integers(0, 300),
)
@settings(max_examples=200, deadline=None)
def test_good_samples_have_angles_after_any_others(run, samples, pose, before):
    """Rates and intervals are drawn; then three good samples follow."""
    drawn = np.array(samples)
    rates = np.vstack([np.tile(GOOD, (before, 1)), drawn[:, :3], np.tile(GOOD, (3, 1))])
    interval_s = np.concatenate([np.full(before, 0.01), drawn[:, 3], np.full(3, 0.01)])
    start = None if pose is None else np.full((1, 3), pose, np.float32)
    angles = run(rates[None].astype(np.float32), interval_s[None].astype(np.float32), start)
    assert np.isfinite(angles[0, -3:]).all()
    there = (np.abs(drawn[:, :3]) <= 30.0).all(axis=1) & (drawn[:, 3] > 0.0)
    found = angles[0, before : before + len(drawn)]
    np.testing.assert_array_equal(np.isfinite(found).all(axis=1), there)
