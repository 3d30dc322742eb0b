"""The unit of angular rates: degrees per second taken for rad/s would pass through unseen."""

import warnings

import numpy as np

from narx.types import FloatArray

# over a recording; a running leg has about 4 rad/s, a slowly walking one 20 deg/s
_LARGEST_RMS_RAD_S = 10.0
# of each recording: enough for a root mean square
_SAMPLES_READ = 1000


def warn_of_degrees(rates_rad_s: FloatArray, where: str) -> None:
    """Warn of rates that no leg has, as those of a walk in degrees per second.

    Parameters
    ----------
    rates_rad_s : ndarray, shape (..., N, 3)
        Angular rates, rad/s; NaN where missing.
    where : str
        Begins the message.
    """
    rates = rates_rad_s[..., :: max(rates_rad_s.shape[-2] // _SAMPLES_READ, 1), :]
    rates = rates[np.isfinite(rates)]
    rms = float(np.sqrt(np.mean(np.square(rates)))) if rates.size else 0.0
    if rms > _LARGEST_RMS_RAD_S:
        warnings.warn(
            f"{where}: the rates have a root mean square of {rms:.3g} rad/s, more than any leg; "
            "are they in degrees per second? Expected rad/s: numpy.radians(rates)",
            UserWarning,
            # the caller of the checked function that asks
            stacklevel=4,
        )
