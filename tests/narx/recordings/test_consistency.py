"""The relation df/dt = -w x f holds on a walk; violations of it are detected."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.recordings.consistency import Fit, contradiction, fit_rotation, is_certain

MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def walk(device_walk):
    return device_walk(50.0, 30.0)


def _verdict(gyroscope, accelerometer, noise=0.0):
    rng = np.random.default_rng(0)
    fit = fit_rotation(
        gyroscope + noise * rng.standard_normal(gyroscope.shape),
        accelerometer + 10 * noise * rng.standard_normal(gyroscope.shape),
        50.0,
    )
    return contradiction(fit)


def test_a_sensor_that_only_turns_gives_slope_one(walk):
    fit = fit_rotation(walk.gyroscope_rad_s, walk.accelerometer_m_s2, 50.0)
    assert fit.slope == pytest.approx(1.0, abs=0.02)
    assert fit.axes == pytest.approx(np.ones(3), abs=0.1)
    assert fit.r2 > 0.99
    assert contradiction(fit) is None


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize(
    ("gyroscope", "accelerometer", "message"),
    [
        (lambda w: w, lambda f: f, None),
        # gyroscope and accelerometer rotated together; the accelerometer points down at rest
        (lambda w: w * [1, -1, -1], lambda f: f * [1, -1, -1], None),
        (lambda w: w, lambda f: -f, None),
        (np.degrees, lambda f: f, "57.* times as fast .* deg/s in a column of rad/s"),
        (np.radians, lambda f: f, "times as fast .* rad/s in a column of deg/s"),
        (lambda w: 2.0 * w, lambda f: f, "2 times as fast .* scale is wrong"),
        (lambda w: 0.5 * w, lambda f: f, "0.5 times as fast .* scale is wrong"),
        (lambda w: -w, lambda f: f, "turns the other way"),
        (lambda w: w * MIRROR, lambda f: f * MIRROR, "turns the other way .* mirrored frame"),
        (lambda w: w * MIRROR, lambda f: f, "turns the other way"),
        (lambda w: w * [-1, 1, 1], lambda f: f, "gyroscope x turns the other way"),
        (lambda w: w[:, [1, 0, 2]], lambda f: f, "axes in the order yxz: columns are exchanged"),
        (lambda w: w[:, [0, 2, 1]], lambda f: f, "axes in the order xzy: columns are exchanged"),
        (lambda w: w[:, [2, 1, 0]], lambda f: f, "axes in the order zyx: columns are exchanged"),
    ],
)
def test_unit_sign_and_handedness(walk, gyroscope, accelerometer, message, noise):
    verdict = _verdict(
        gyroscope(walk.gyroscope_rad_s), accelerometer(walk.accelerometer_m_s2), noise
    )
    if message is None:
        assert verdict is None
    else:
        assert verdict is not None
        assert re.search(message, verdict)


def test_nothing_is_concluded_from_rest(walk):
    still = slice(0, 200)
    assert fit_rotation(walk.gyroscope_rad_s[still], walk.accelerometer_m_s2[still], 50.0) is None
    nothing = np.full((1500, 3), np.nan)
    assert fit_rotation(walk.gyroscope_rad_s, nothing, 50.0) is None


@pytest.mark.recordings
def test_recorded_walks_are_not_doubted(data_root):
    from narx.datasets.neura_sample import NeuraSample
    from narx.datasets.smartphone_pocket import SmartphonePocket

    for source in (
        SmartphonePocket(root=data_root / "smartphone_pocket"),
        NeuraSample(root=data_root / "neura_sample"),
    ):
        for trial in source:
            for imu in trial.imus.values():
                signals = imu.gyroscope_rad_s, imu.accelerometer_m_s2, trial.sampling_rate_hz
                fit = fit_rotation(*signals)
                assert contradiction(fit) is None
                assert 0.3 < fit.slope < 1.0
                gyroscope, accelerometer, rate_hz = signals
                wrong = {
                    "deg/s in a column of rad/s": (np.degrees(gyroscope), accelerometer),
                    "rad/s in a column of deg/s": (np.radians(gyroscope), accelerometer),
                    "mirrored frame": (gyroscope * MIRROR, accelerometer * MIRROR),
                }
                for message, pair in wrong.items():
                    assert message in contradiction(fit_rotation(*pair, rate_hz))


def test_only_frequencies_below_1_5_hz_are_compared():
    """Impacts of a walk shake the accelerometer at 5 Hz without turning it."""
    time_s = np.arange(0.0, 40.0, 0.01)
    angle = 0.5 * np.sin(2 * np.pi * 0.8 * time_s)
    rate = np.random.default_rng(0).normal(0.0, 0.02, (len(time_s), 3))
    rate[:, 1] = 0.5 * 2 * np.pi * 0.8 * np.cos(2 * np.pi * 0.8 * time_s)
    force = 9.81 * np.column_stack([-np.sin(angle), 0 * angle, np.cos(angle)])
    clean = fit_rotation(rate, force, 100.0)
    assert clean.slope == pytest.approx(1.0, abs=0.03)
    force[:, 0] += 4.0 * np.sin(2 * np.pi * 5.0 * time_s)
    force[:, 2] += 4.0 * np.cos(2 * np.pi * 5.0 * time_s)
    shaken = fit_rotation(rate, force, 100.0)
    assert shaken.r2 > 0.95
    assert shaken.slope == pytest.approx(clean.slope, abs=0.05)
    # a rotation at 3 Hz is too fast for the comparison: nothing moves
    fast = 0.1 * rate
    fast[:, 1] = np.cos(2 * np.pi * 6.0 * time_s)
    still = np.tile([0.0, 0.0, 9.81], (len(time_s), 1))
    assert fit_rotation(fast, still, 100.0) is None


def test_the_standard_errors_are_those_of_repeated_noise(walk):
    """Filtered samples are not independent: their number would give errors that are too small."""
    rng = np.random.default_rng(0)
    fits = [
        fit_rotation(
            walk.gyroscope_rad_s,
            walk.accelerometer_m_s2 + 5.0 * rng.standard_normal(walk.accelerometer_m_s2.shape),
            50.0,
        )
        for _ in range(60)
    ]
    scatter = np.std([fit.axes for fit in fits], axis=0)
    predicted = np.mean([fit.axes / fit.t for fit in fits], axis=0)
    np.testing.assert_allclose(scatter / predicted, 1.0, atol=0.5)


LOOSE = Fit(1.0, 0.5, np.ones(3), np.full(3, 9.0), 0.3, "xyz", 0.3)
CLOSE = {"r2": 0.81, "r2_of_order": 0.81}


@pytest.mark.parametrize(
    ("changes", "message", "certain"),
    [
        ({"correlation": -0.24}, None, False),
        ({"correlation": -0.26}, "turns the other way", False),
        ({"correlation": -0.46}, "turns the other way", True),
        ({"correlation": -0.26, **CLOSE}, "turns the other way", True),
        ({"slope": 0.09}, None, False),
        ({"slope": 0.07}, "times as fast", True),
        ({"slope": 0.07, "correlation": 0.24}, None, False),
        ({"slope": 4.9}, None, False),
        ({"slope": 5.1}, "times as fast", True),
        ({"axes": np.array([1, -0.31, 1]), "t": np.array([9, -8.1, 9])}, "gyroscope y", False),
        ({"axes": np.array([1, -0.31, 1]), "t": np.array([9, -7.9, 9])}, None, False),
        ({"slope": 0.69}, None, False),
        ({"slope": 0.69, **CLOSE}, "scale is wrong", True),
        ({"slope": 0.71, **CLOSE}, None, True),
        ({"order": "yxz", "r2_of_order": 0.81}, "columns are exchanged", True),
        ({"order": "yxz", "r2_of_order": 0.79}, None, False),
    ],
)
def test_limits_of_what_contradicts(changes, message, certain):
    fit = replace(LOOSE, **changes)
    found = contradiction(fit)
    assert (found is None) == (message is None)
    assert message is None or message in found
    assert is_certain(fit) == certain


def _turning(angles_rad, noise):
    """Rates and specific force of a sensor that only turns, sampled at 50 Hz."""
    turned = Rotation.from_euler("ZYX", angles_rad)
    steps = (turned[:-1].inv() * turned[1:]).as_rotvec() * 50.0
    rates = np.vstack([steps[:1], 0.5 * (steps[1:] + steps[:-1]), steps[-1:]])
    white = np.random.default_rng(0).standard_normal(rates.shape)
    return rates, turned.inv().apply([0.0, 0.0, 9.81]) + noise * white


@pytest.mark.parametrize(("speed_rad_s", "moves"), [(0.2, False), (0.45, True)])
def test_swaying_is_no_movement(speed_rad_s, moves):
    """A walk turns by more than 0.35 rad/s on average over a second."""
    time_s = np.arange(0.0, 30.0, 0.02)
    phase = 2 * np.pi * 0.5 * time_s
    sway = np.column_stack([0 * phase, np.sin(phase), np.cos(phase)]) / np.pi
    fit = fit_rotation(*_turning(speed_rad_s * sway, 0.0), 50.0)
    assert (fit is not None) == moves


def test_the_order_of_the_file_explains_what_the_fit_does():
    """The same share by either formula, although the force changes by more than zero on average."""
    time_s = np.arange(0.0, 8.0, 0.02)
    swing = np.sin(2 * np.pi * np.outer(time_s, [0.5, 0.4, 0.3]) + [0.0, 1.0, 0.0])
    rates, force = _turning(0.3 * swing + np.outer(time_s, [0.0, 0.15, 0.0]), 3.0)
    fit = fit_rotation(rates, force, 50.0)
    assert fit.order == "xyz"
    assert 0.2 < fit.r2 < 0.95
    assert fit.r2_of_order == pytest.approx(fit.r2, abs=1e-9)
