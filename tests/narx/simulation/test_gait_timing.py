"""Foot contacts: events as phases, stride times as published."""

from dataclasses import replace

import numpy as np
import pytest

from narx.simulation.gait_timing import STRIDE_TIME_CV, overground_timing, treadmill_timing

TOE_OFF, LAG = 0.64, 0.52


def _treadmill(seed=0, duration_s=300.0):
    rng = np.random.default_rng(seed)
    return treadmill_timing(rng, 1.2, TOE_OFF, LAG, 4.0, 4.0, duration_s, 2)


def test_events_lie_on_the_phase():
    timing = _treadmill()
    for name, instant in (
        ("heel_strike_right", 0.0),
        ("heel_strike_left", LAG),
        ("toe_off_right", TOE_OFF),
        ("toe_off_left", TOE_OFF + LAG),
    ):
        phase = timing.phase_of_time(timing.events[name]) - instant
        np.testing.assert_allclose(phase, np.round(phase), atol=1e-4)
        assert np.all((timing.events[name] > 4.0) & (timing.events[name] < 300.0))


def test_stride_times_vary_as_people_s_do():
    strides = np.concatenate(
        [np.diff(_treadmill(seed).events["heel_strike_right"])[8:] for seed in range(10)]
    )
    assert strides.mean() == pytest.approx(1.2, rel=0.01)
    assert strides.std() / strides.mean() == pytest.approx(STRIDE_TIME_CV, rel=0.25)
    assert strides.min() > 1.0


def test_the_belt_starts_slowly():
    timing = _treadmill()
    strides = np.diff(timing.events["heel_strike_right"])
    assert strides[0] > 1.2 * strides[10:].mean()
    size = timing.size(np.array([0.0, 4.0, 6.0, 8.0, 299.9]))
    np.testing.assert_allclose(size, [0.0, 0.0, 0.5, 1.0, 1.0], atol=1e-9)


@pytest.mark.parametrize("n_steps", [1, 3, 5, 12])
def test_steps_over_ground_are_counted(n_steps):
    for seed in range(6):
        rng = np.random.default_rng(seed)
        timing = overground_timing(rng, 1.1, TOE_OFF, LAG, 3.5, n_steps, 4.0, 2)
        assert timing.start_s == pytest.approx(3.5)
        assert timing.end_s == pytest.approx(3.5 + 0.55 * n_steps)
        strikes = np.sort(
            np.concatenate([timing.events[f"heel_strike_{s}"] for s in ("right", "left")])
        )
        # the closing step is set down flat
        assert len(strikes) == n_steps - 1
        assert np.all(timing.size(np.array([0.0, 3.5, timing.end_s, timing.end_s + 3.0])) == 0.0)


def test_a_walk_begins_and_ends_at_its_own_pace():
    timing = replace(_treadmill(), end_s=100.0, rise_s=4.0, fall_s=1.0)
    size = timing.size(np.array([6.0, 98.9, 99.5, 100.0]))
    np.testing.assert_allclose(size, [0.5, 1.0, 0.5, 0.0], atol=1e-9)


def test_no_event_is_missing_at_the_end():
    """Every event of a stride that ends before the recording does."""
    timing = _treadmill()
    for name, instant in (("heel_strike_right", 0.0), ("toe_off_left", TOE_OFF + LAG)):
        last = timing.phase_of_time(299.99) - instant
        found = timing.phase_of_time(timing.events[name][-1]) - instant
        assert round(float(found)) == np.floor(last)


def test_the_phase_always_grows():
    timing = _treadmill(3)
    assert np.all(np.diff(timing.phase_of_time(np.arange(-1.0, 301.0, 0.01))) > 0.0)


def test_the_variation_of_joints_is_not_that_of_the_stride_times():
    """Stride times and every channel are drawn apart: what they have in common is chance."""
    rng = np.random.default_rng(5)
    timing = treadmill_timing(rng, 1.0, TOE_OFF, LAG, 1.0, 1.0, 2000.0, 2)
    strikes = timing.events["heel_strike_right"][10:]
    phase = np.round(timing.phase_of_time(strikes))
    both = timing.variation(phase[:-1], slice(0, 2))
    assert np.abs(np.corrcoef(np.diff(strikes), both.T)[0, 1:]).max() < 0.25
    assert both.std() == pytest.approx(1.0, abs=0.3)


def test_strides_do_not_run_out_before_the_recording_does():
    """Of 30,000 strides, whose slow variation adds up to some dozen more or less."""
    for seed in range(5):
        rng = np.random.default_rng(seed)
        timing = treadmill_timing(rng, 0.01, TOE_OFF, LAG, 1.0, 1.0, 301.0, 1)
        assert timing.phase_of_time.t[-1] > 301.0


def test_over_ground_the_first_and_the_last_step_grow_with_the_stride():
    rng = np.random.default_rng(0)
    timing = overground_timing(rng, 2.0, TOE_OFF, LAG, 3.0, 8, 4.0, 1)
    np.testing.assert_allclose(timing.size(np.array([3.6, 4.2, 9.8, 10.4])), [0.5, 1.0, 1.0, 0.5])


def test_no_foot_strikes_as_the_walk_begins():
    """The standing foot lifts at once; one fifth of a stride passes before the first strike."""
    for seed in range(8):
        timing = _treadmill(seed)
        first = min(timing.events[f"heel_strike_{side}"][0] for side in ("right", "left"))
        assert 4.24 < first < 6.2
