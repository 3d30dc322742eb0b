"""Adapter to Mahony's explicit complementary filter (library `ahrs`), without magnetometer."""

from narx.baselines.ahrs_filter import AhrsFilter
from narx.baselines.parameters import positive


class Mahony(AhrsFilter):
    """Mahony's filter with gyroscope and accelerometer.

    Parameters
    ----------
    proportional_gain : float
        Correction of the rates towards the accelerometer, 1/s (k_P).
    integral_gain : float
        Correction of the gyroscope's bias, 1/s^2 (k_I).

    Raises
    ------
    MethodNotApplicableError
        If the package `ahrs` is not installed.

    Notes
    -----
    R. Mahony, T. Hamel and J.-M. Pflimlin, IEEE Transactions on Automatic Control 53(5), 2008.
    The library makes no correction at a sample whose rates are all exactly zero. It runs in
    Python, at some 60 microseconds a sample.
    """

    name = "mahony"
    library_class = "Mahony"

    def __init__(self, proportional_gain: float = 1.0, integral_gain: float = 0.3) -> None:
        super().__init__(
            {
                "k_P": positive(self.name, "proportional_gain", proportional_gain),
                "k_I": positive(self.name, "integral_gain", integral_gain),
            }
        )
