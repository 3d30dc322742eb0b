"""Stride frequency, gait phases, standing and walking, from one sensor."""

from narx.gait.phases import GaitPhases, gait_phases
from narx.gait.standing import StillThresholds, start_and_stop
from narx.gait.stride_frequency import StrideFrequencyTracker, stride_frequency_hz
from narx.gait.strides import normalised_strides

__all__ = [
    "GaitPhases",
    "StillThresholds",
    "StrideFrequencyTracker",
    "gait_phases",
    "normalised_strides",
    "start_and_stop",
    "stride_frequency_hz",
]
