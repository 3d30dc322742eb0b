"""Run a network at the sampling rate it was trained at, whatever the recording's rate.

A trained recurrence is tied to its sampling interval. Instead of changing its weights, the
recording is brought to the network's clock and the angles back to the recording's. Both ways go
through the integral of the rate, so nothing aliases and no angle is lost in between.
"""

import numpy as np
from scipy.integrate import cumulative_trapezoid

from narx.types import FloatArray


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
        rates = np.asarray(rates_rad_s, dtype=np.float64)
        half_s = 0.5 / network_rate_hz
        self._time_s = np.arange(len(rates)) / recording_rate_hz
        self._integral = np.zeros(rates.shape)
        self._network_time_s = np.empty(0)
        self._network_integral = self.network_rates_rad_s = np.empty_like(rates)
        if not len(rates):
            return
        self._integral[1:] = cumulative_trapezoid(rates, dx=1.0 / recording_rate_hz, axis=0)
        n_network = int(np.floor(self._time_s[-1] * network_rate_hz + 1e-9)) + 1
        self._network_time_s = np.arange(n_network) / network_rate_hz
        # beyond the recording's ends the rate stays what it was there
        time_s = np.concatenate([[-half_s], self._time_s, [self._time_s[-1] + half_s]])
        integral = np.concatenate(
            [-half_s * rates[:1], self._integral, self._integral[-1:] + half_s * rates[-1:]]
        )
        self._network_integral = _interpolate(self._network_time_s, time_s, integral)
        # mean rate from half a tick before to half a tick after: nothing that turned is lost, and
        # the network, which joins samples as by trapezoids, is not fed half a sample late
        edges_s = (np.arange(n_network + 1, dtype=np.float64) - 0.5) / network_rate_hz
        between = _interpolate(edges_s, time_s, integral)
        self.network_rates_rad_s = np.diff(between, axis=0) * network_rate_hz

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
    return np.stack(
        [np.interp(wanted_s, time_s, values[:, c]) for c in range(values.shape[1])], axis=1
    )
