"""Recordings: sensors on one uniform clock, with a reference where there is one."""

from narx.recordings.trial import ImuRecording, ReferenceOrientation, Trial

__all__ = [
    "ImuRecording",
    "ReferenceOrientation",
    "Trial",
]
