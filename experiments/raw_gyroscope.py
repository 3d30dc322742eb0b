"""Restore the static gyroscope bias of a calibrated segment."""

from dataclasses import replace

from narx.calibration.calibrate import CalibratedSegment
from narx.kinematics.segment_angles import clinical_rates
from narx.recordings.trial import side_of


def with_static_bias(segment: CalibratedSegment) -> CalibratedSegment:
    """Undo the removal of the static bias, for methods that must handle it themselves.

    Parameters
    ----------
    segment : CalibratedSegment
        From `narx.calibration.calibrate.calibrate`.

    Returns
    -------
    CalibratedSegment
        The same frames and reference, with the rates as measured by the sensor.
    """
    bias = segment.sensor_to_anatomical.apply(segment.static_bias_rad_s)
    rates = segment.signals.axis_rates_rad_s + clinical_rates(
        bias, side_of(segment.signals.segment)
    )
    return replace(
        segment,
        signals=replace(segment.signals, axis_rates_rad_s=rates),
        notes=(*segment.notes, "static gyroscope bias restored"),
    )
