"""Sensors move relative to their segments: in a hand before the walk, and by slips."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.datasets.simulated_gait import SimulatedGait
from narx.errors import UserError
from narx.simulation.attachment import Attachment, carried
from narx.simulation.inertial import angular_rate

SHORT = {
    "subjects": ["S1"],
    "conditions": ["normal"],
    "treadmill_duration_s": 16.0,
    "segments": ["thigh_right"],
    "ideal": True,
}


def _rotation(wxyz):
    return Rotation.from_quat(wxyz, scalar_first=True)


def _thigh(**options):
    source = SimulatedGait(**SHORT, **options)
    names = "S1", "normal", "1"
    return source.load(*names), source.truth(*names)


@pytest.fixture(scope="module")
def fixed():
    return _thigh()


@pytest.mark.parametrize(
    "attachment",
    [Attachment(5.0), Attachment(slips_s=(3.0, 6.0)), Attachment(2.5, (4.0,), 60.0)],
    ids=["hand", "slips", "both"],
)
def test_rates_integrate_to_the_true_rotation(attachment, integrated):
    time_s = np.arange(-500, 5000) / 500.0
    moved = attachment.rotation(np.random.default_rng(1), time_s)
    inner = slice(20, -20)
    rate = angular_rate(moved, 500.0)[inner]
    found = integrated(rate, 500.0, moved[inner][1])
    error = (found.inv() * moved[inner][1:-1]).magnitude()
    assert error.max() < 1e-6
    assert np.degrees(moved.magnitude().max()) > 15.0


def test_a_sensor_in_a_hand_is_in_its_place_before_the_walk():
    trial, truth = _thigh(handling_s=6.0)
    segment = _rotation(truth.segment_wxyz["thigh_right"])
    carried_by = segment.inv() * _rotation(truth.sensor_wxyz["thigh_right"])
    moved = np.degrees((carried_by * carried_by[-1].inv()).magnitude())
    assert moved[trial.time_s >= 6.0].max() < 1e-6
    in_hand = moved[trial.time_s < 4.5]
    # turned by 40 to 80 degrees, with three times the motion of the hand
    assert in_hand.min() > 16.0
    assert in_hand.max() < 104.0
    assert np.ptp(in_hand) > 2.0
    assert not trial.starts_in_calibration_posture
    assert trial.still_s[0] == (6.0, 10.0)
    assert trial.walking_s == (10.0, trial.time_s[-1])


def test_the_reference_follows_the_sensor(fixed):
    (plain, _), (trial, truth) = fixed, _thigh(slips_s=[12.0], slip_deg=35.0)
    before = trial.time_s < 12.0
    for name, channel in (("imus", "gyroscope_rad_s"), ("reference", "quaternion_wxyz")):
        one, other = (getattr(getattr(t, name)["thigh_right"], channel) for t in (trial, plain))
        np.testing.assert_allclose(one[before], other[before], rtol=0.0, atol=1e-5)
    found = _rotation(trial.reference["thigh_right"].quaternion_wxyz)
    slipped = _rotation(plain.reference["thigh_right"].quaternion_wxyz).inv() * found
    angle = np.degrees(slipped.magnitude())
    np.testing.assert_allclose(angle[trial.time_s > 12.3], 35.0, atol=1e-6)
    # the sensor's orientation relative to the reference never changes
    mounting = found.inv() * _rotation(truth.sensor_wxyz["thigh_right"])
    assert (mounting[0].inv() * mounting).magnitude().max() < 1e-9


def test_missing_orientations_stay_missing():
    wxyz = np.array([[1.0, 0.0, 0.0, 0.0], [np.nan] * 4])
    found = carried(wxyz, Rotation.from_rotvec([[0.0, 0.0, np.pi / 2.0]] * 2))
    np.testing.assert_allclose(found[0], [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
    assert np.isnan(found[1]).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"handling_s": 0.5}, "handling_s is 0.5"),
        ({"handling_s": -1.0}, "handling_s"),
        ({"slips_s": [5.0]}, "slips_s has 5"),
        ({"slips_s": [10.0, 10.1]}, "slips_s has 10.1"),
        ({"slips_s": [15.9]}, "slips_s has 15.9"),
        ({"slips_s": [float("nan")]}, "slips_s"),
        ({"slips_s": [10.0], "slip_deg": 181.0}, "slip_deg"),
    ],
)
def test_times_without_room_are_refused(options, message):
    with pytest.raises(UserError, match=message):
        SimulatedGait(**SHORT, **options)


def test_slips_are_those_of_a_treadmill():
    with pytest.raises(UserError, match="slips_s is for protocol=treadmill"):
        SimulatedGait(protocol="stand_walk_stand", slips_s=[12.0])
