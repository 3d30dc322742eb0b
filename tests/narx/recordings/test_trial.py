"""Recordings and trials refuse what is not their type, and keep their own copy."""

import re
from datetime import UTC, datetime

import numpy as np
import pandas as pd
import pytest
import torch

from narx.errors import RecordingError, UserError
from narx.recordings.trial import ImuRecording, ReferenceOrientation, Trial

N = 50
TIME_S = np.arange(N) / 100.0


def recording(**fields):
    given = {"segment": "thigh_right", "time_s": TIME_S, "gyroscope_rad_s": np.ones((N, 3)),
             "accelerometer_m_s2": np.ones((N, 3))}  # fmt: skip
    return ImuRecording(**given | fields)


def test_what_is_masked_is_missing():
    values = np.ma.masked_greater(np.arange(3.0 * N).reshape(N, 3), 100.0)
    found = recording(gyroscope_rad_s=values).gyroscope_rad_s
    np.testing.assert_array_equal(np.isnan(found), values.mask)
    assert not isinstance(found, np.ma.MaskedArray)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", [torch.tensor, pd.DataFrame, np.asfortranarray, np.ndarray.tolist])
def test_any_table_of_numbers_is_taken(kind):
    values = np.arange(3.0 * N).reshape(N, 3)
    np.testing.assert_array_equal(recording(gyroscope_rad_s=kind(values)).gyroscope_rad_s, values)


def test_a_later_change_by_the_caller_does_not_reach_the_recording():
    values = np.ones((N, 3))
    imu = recording(gyroscope_rad_s=values, accelerometer_m_s2=values, time_s=(time := TIME_S + 1))
    values[:], time[:] = np.nan, 0.0
    assert (imu.gyroscope_rad_s == 1.0).all()
    assert (imu.accelerometer_m_s2 == 1.0).all()
    assert imu.time_s[0] == 1.0


@pytest.mark.parametrize(
    "values",
    [
        np.ones((N, 3)) * 1j, np.zeros((N, 3), dtype="datetime64[s]"), "rates", None,
        [[datetime(2020, 1, 1, tzinfo=UTC)] * 3] * N, {"x": 1}, [[1], [2, 3]],
    ],
    ids=["complex", "dates", "a word", "nothing", "date times", "a section", "ragged"],
)  # fmt: skip
@pytest.mark.parametrize("field", ["time_s", "gyroscope_rad_s", "accelerometer_m_s2"])
def test_what_is_no_real_number_is_refused(field, values):
    with pytest.raises(UserError, match=f"{field} ") as refused:
        recording(**{field: values})
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"imus": recording()}, "imus is ImuRecording"),
        ({"imus": {"thigh_right": None}}, "imus.thigh_right is null, expected ImuRecording"),
        ({"reference": [1]}, "reference is [1], expected a section"),
        ({"scored": "all"}, "scored is 'all', expected"),
        ({"straight": "no"}, "straight is 'no', expected True or False"),
        ({"sampling_rate_hz": float("nan")}, "sampling_rate_hz is nan, expected a number"),
        ({"subject": None}, "subject is null, expected a name"),
    ],
)
def test_a_trial_of_other_types_is_refused(fields, said):
    given = {"dataset": "d", "subject": "s", "condition": "c", "trial": "t",
             "sampling_rate_hz": 100.0, "imus": {"thigh_right": recording()}}  # fmt: skip
    with pytest.raises(UserError, match=rf"^Trial\.{re.escape(said)}"):
        Trial(**given | fields)
    assert Trial(**given | {"straight": np.True_}).straight is True


def test_shapes_are_refused_as_before():
    with pytest.raises(RecordingError, match=r"IMU 'thigh_right': gyroscope_rad_s has shape"):
        recording(gyroscope_rad_s=np.ones((N, 2)))


def test_a_quaternion_is_of_unit_norm_within_a_thousandth_and_normalised():
    rounded = np.tile([0.6006, 0.8, 0.0, 0.0], (N, 1))
    found = ReferenceOrientation("thigh_right", rounded, "sensor").quaternion_wxyz
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, atol=1e-15)
    with pytest.raises(RecordingError, match=r"quaternion 0 has norm 1\.0020, expected 1"):
        ReferenceOrientation("thigh_right", 1.002 * np.eye(4), "sensor")


@pytest.mark.parametrize(("late_s", "uniform"), [(5e-6, True), (2e-5, False)])
def test_a_trial_has_a_clock_that_is_uniform_within_a_thousandth(late_s, uniform):
    time_s = TIME_S.copy()
    time_s[20] += late_s
    imus = {"thigh_right": recording(time_s=time_s)}
    if uniform:
        Trial("d", "s", "c", "t", 100.0, imus)
        return
    with pytest.raises(RecordingError, match="not sampled uniformly at 100 Hz"):
        Trial("d", "s", "c", "t", 100.0, imus)
