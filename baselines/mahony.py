"""Mahony's explicit complementary filter, without magnetometer."""

from narx.baselines.ahrs_filter import AhrsFilter
from narx.baselines.parameters import positive
from narx.baselines.recursive import GivenStartUp
from narx.kernels.ahrs import mahony


class Mahony(AhrsFilter):
    """Mahony's filter with gyroscope and accelerometer.

    Parameters
    ----------
    proportional_gain : float
        Correction of the rates towards the accelerometer, 1/s (k_P).
    integral_gain : float
        Correction of the gyroscope's bias, 1/s^2 (k_I).
    heading, heading_leak_rad_s, start_up
        As in `narx.baselines.orientation_filter.OrientationFilter`.

    Notes
    -----
    R. Mahony, T. Hamel and J.-M. Pflimlin, IEEE Transactions on Automatic Control 53(5), 2008. The
    results equal those of the library `ahrs`, which makes no step at a sample whose rates are all
    exactly zero.
    """

    name = "mahony"
    kernel = mahony

    def __init__(
        self,
        proportional_gain: float = 1.0,
        integral_gain: float = 0.3,
        heading: str = "own",
        heading_leak_rad_s: float = 0.3,
        start_up: GivenStartUp = None,
    ) -> None:
        super().__init__(
            (
                positive(self.name, "proportional_gain", proportional_gain),
                positive(self.name, "integral_gain", integral_gain),
            ),
            heading=heading,
            heading_leak_rad_s=heading_leak_rad_s,
            start_up=start_up,
        )
