"""Run a network at the sampling rate it was trained at, whatever the recording's rate.

A trained recurrence is tied to its sampling interval. Instead of changing its weights, the
recording is brought to the network's clock and the angles back to the recording's. Both ways go
through the integral of the rate, so nothing aliases and no angle is lost in between.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

FloatArray = NDArray[np.float64]


class RateConversion:
    """A recording's clock beside the network's.

    Parameters
    ----------
    rates_rad_s : ndarray, shape (N, C)
        Angular rates on the recording's clock, no NaN.
    recording_rate_hz : float
        Sampling rate of the recording.
    network_rate_hz : float
        Sampling rate of the network.
    """

    def __init__(
        self, rates_rad_s: FloatArray, recording_rate_hz: float, network_rate_hz: float
    ) -> None:
        self._time_s = np.arange(len(rates_rad_s)) / recording_rate_hz
        self._integral = np.zeros(np.shape(rates_rad_s))
        n_network = 0
        if len(rates_rad_s):
            self._integral[1:] = cumulative_trapezoid(
                rates_rad_s, dx=1.0 / recording_rate_hz, axis=0
            )
            n_network = int(np.floor(self._time_s[-1] * network_rate_hz + 1e-9)) + 1
        self._network_time_s = np.arange(n_network) / network_rate_hz
        self._network_integral = _interpolate(self._network_time_s, self._time_s, self._integral)
        # mean rate between two ticks of the network: what turned in between is kept exactly
        self.network_rates_rad_s = np.concatenate(
            [rates_rad_s[:1], np.diff(self._network_integral, axis=0) * network_rate_hz]
        )

    def to_recording(self, angles_rad: FloatArray) -> FloatArray:
        """Bring the network's angles back to the recording's clock.

        Parameters
        ----------
        angles_rad : ndarray, shape (N_network, C)
            Angles at the network's ticks.

        Returns
        -------
        ndarray, shape (N, C)
            Angles at the recording's samples: the recording's own integral plus the slow
            difference between network and integral, interpolated.
        """
        if not len(angles_rad):
            return np.empty_like(self._integral)
        slow = angles_rad - self._network_integral
        return self._integral + _interpolate(self._time_s, self._network_time_s, slow)


def _interpolate(wanted_s: FloatArray, time_s: FloatArray, values: FloatArray) -> FloatArray:
    if not len(time_s):
        return np.empty((len(wanted_s), values.shape[1]))
    return np.stack(
        [np.interp(wanted_s, time_s, values[:, c]) for c in range(values.shape[1])], axis=1
    )
