"""Adapter to Madgwick's gradient-descent filter (library `ahrs`), without magnetometer."""

from narx.baselines.ahrs_filter import AhrsFilter
from narx.baselines.parameters import positive


class Madgwick(AhrsFilter):
    """Madgwick's filter with gyroscope and accelerometer.

    Parameters
    ----------
    gain : float
        Step of the correction towards the accelerometer, rad/s (beta).

    Raises
    ------
    MethodNotApplicableError
        If the package `ahrs` is not installed.

    Notes
    -----
    S. O. H. Madgwick, A. J. L. Harrison and R. Vaidyanathan, ICORR 2011. The library makes no
    correction at a sample whose rates are all exactly zero. It runs in Python, at some
    50 microseconds a sample.
    """

    name = "madgwick"
    library_class = "Madgwick"

    def __init__(self, gain: float = 0.033) -> None:
        super().__init__({"gain": positive(self.name, "gain", gain)})
