"""Madgwick's gradient-descent filter, without magnetometer."""

from narx.baselines.ahrs_filter import AhrsFilter
from narx.baselines.parameters import positive
from narx.baselines.recursive import GivenStartUp
from narx.kernels.ahrs import madgwick


class Madgwick(AhrsFilter):
    """Madgwick's filter with gyroscope and accelerometer.

    Parameters
    ----------
    gain : float
        Step of the correction towards the accelerometer, rad/s (beta).
    heading, heading_leak_rad_s, start_up
        As in `narx.baselines.orientation_filter.OrientationFilter`.

    Notes
    -----
    S. O. H. Madgwick, A. J. L. Harrison and R. Vaidyanathan, ICORR 2011. The results equal those of
    the library `ahrs`, which makes no step at a sample whose rates are all exactly zero.
    """

    name = "madgwick"
    kernel = madgwick

    def __init__(
        self,
        gain: float = 0.033,
        heading: str = "own",
        heading_leak_rad_s: float = 0.3,
        start_up: GivenStartUp = None,
    ) -> None:
        super().__init__(
            positive(self.name, "gain", gain),
            heading=heading,
            heading_leak_rad_s=heading_leak_rad_s,
            start_up=start_up,
        )
