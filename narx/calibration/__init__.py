"""Sensor-to-segment alignment, and the gyroscope's static bias."""

from narx.calibration.calibrate import CalibratedSegment, calibrate
from narx.calibration.static_bias import static_bias

__all__ = [
    "CalibratedSegment",
    "calibrate",
    "static_bias",
]
