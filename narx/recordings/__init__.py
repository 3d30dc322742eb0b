"""Recordings: sensors on one uniform clock, with an optional reference."""

from narx.recordings.trial import ImuRecording, ReferenceOrientation, Trial

__all__ = [
    "ImuRecording",
    "ReferenceOrientation",
    "Trial",
]
