"""A trained network with a tracker of posture and bias (`narx.inference.tracker`)."""

import math
from dataclasses import replace

import numpy as np

from narx.errors import MethodNotApplicableError
from narx.inference.clocks import RateConversion
from narx.inference.narx_method import NarxMethod, NetworkEstimate, quality_of
from narx.inference.tracked_recursion import TrackedRecursion
from narx.inference.tracker import PostureTracker
from narx.inference.tracking import Tracked, Tracking, follow
from narx.kernels import leg
from narx.kernels import tracker_layout as kernel
from narx.kernels.clock import ARRIVED, DOUBTFUL
from narx.method import SegmentSignals
from narx.missing import finite_rows
from narx.network.model import Narx
from narx.recordings.resampling import contiguous_pieces
from narx.recursion import Recursion
from narx.settings import Flag, checked
from narx.types import BoolArray, FloatArray

# bias of uncalibrated gyroscopes (docs/simulator.md)
_DOUBTFUL_BIAS_DEG_S = 2.0


class TrackedNarxMethod(NarxMethod):
    """Run a trained network about a tracked posture, with a standard deviation for each sample.

    Parameters
    ----------
    model : Narx
        Trained network, coupled and odd.
    tracker : PostureTracker
        Parameters of the Kalman filter.
    smoothing : bool
        Also run backwards, and average both passes weighted by their variances: smaller errors,
        whole recordings only.
    """

    @checked
    def __init__(self, model: Narx, tracker: PostureTracker, smoothing: Flag = False) -> None:
        super().__init__(model, smoothing=smoothing)
        self.tracker = tracker
        self.needs_accelerometer = tracker.aided  # type: ignore[misc]

    counted_gap_s = kernel.LONGEST_GAP_S

    def estimate(self, signals: SegmentSignals) -> FloatArray:
        """Estimate the angles of a whole recording.

        Parameters
        ----------
        signals : SegmentSignals
            Calibrated signals; NaN where missing. The duration of gaps is taken into account.

        Returns
        -------
        ndarray, shape (N, 3)
            Sagittal, frontal and transverse angle in rad; NaN at missing samples.
        """
        return self.run(signals).angles_rad

    def run(self, signals: SegmentSignals) -> NetworkEstimate:
        """Estimate angles, their standard deviation, and what stands behind each sample.

        Parameters
        ----------
        signals : SegmentSignals
            As for `estimate`.

        Returns
        -------
        NetworkEstimate
            From one pass of the tracker; the network does not work (`starting`) before walking and
            between walks.
        """
        there = self.usable(signals)
        angles, std, growth, corrected, by_network = self._follow(signals, there)
        starting = ~by_network & finite_rows(angles)
        quality = quality_of(there, starting, signals.interval_s)
        doubtful = growth > leg.DOUBTFUL_GROWTH
        doubtful |= (corrected > kernel.MOST_CORRECTED_RAD).any(axis=1)
        quality[(quality == ARRIVED) & doubtful] = DOUBTFUL
        std = std * growth[:, None] * np.array(self.tracker.std_scale)
        std = np.sqrt(std * std + corrected * corrected)
        if signals.initial_angles_rad is not None:
            std = np.maximum(std, math.radians(self.tracker.alignment_sd_deg))
        return NetworkEstimate(angles, std, starting, quality)

    @property
    def takes_over(self) -> str:
        """When the network takes over from the integration, as text."""
        return "after the first swing of the leg in walking"

    def with_doubtful_bias(self) -> "TrackedNarxMethod":
        """Return the method for a recording whose gyroscope bias is unknown.

        Returns
        -------
        TrackedNarxMethod
            The method with a standard deviation of the bias of at least 2 deg/s.
        """
        tracker = replace(
            self.tracker,
            bias_sd_deg_s=max(self.tracker.bias_sd_deg_s, _DOUBTFUL_BIAS_DEG_S),
            known_bias_sd_deg_s=max(self.tracker.known_bias_sd_deg_s, _DOUBTFUL_BIAS_DEG_S),
        )
        return TrackedNarxMethod(self.model, tracker, self.smoothing)

    def _follow(self, signals: SegmentSignals, there: BoolArray) -> Tracked:
        if there.all():
            return self._follow_bridged(signals)
        angles, std, corrected = np.full((3, signals.n_samples, 3), np.nan)
        growth, by_network = np.full(signals.n_samples, np.nan), np.zeros(len(there), dtype=bool)
        if there.any():
            bridged, tick_of = self.bridged(signals)
            tracked, at = self._follow_bridged(bridged), tick_of[there]
            angles[there], std[there] = tracked.angles_rad[at], tracked.std_rad[at]
            growth[there], by_network[there] = tracked.std_growth[at], tracked.by_network[at]
            corrected[there] = tracked.corrected_rad[at]
        return Tracked(angles, std, growth, corrected, by_network)

    def _follow_bridged(self, signals: SegmentSignals) -> Tracked:
        rate_hz = self.model.sampling_rate_hz
        inputs = signals.axis_rates_rad_s
        if self.tracker.aided:
            inputs = np.hstack([inputs, signals.specific_force_m_s2])
        if np.isclose(signals.sampling_rate_hz, rate_hz, rtol=1e-6):
            return self._at_network_rate_tracked(inputs, signals.initial_angles_rad)
        return self._converted(inputs, signals)

    def _converted(self, inputs: FloatArray, signals: SegmentSignals) -> Tracked:
        n, rate_hz = len(inputs), self.model.sampling_rate_hz
        ratio = rate_hz / signals.sampling_rate_hz
        there = finite_rows(inputs)
        time_s = np.arange(n) * signals.interval_s
        pieces = contiguous_pieces(time_s, there, 1.5 * signals.interval_s)
        conversions = [RateConversion(inputs[p], signals.sampling_rate_hz, rate_hz) for p in pieces]
        # each piece has its own clock, which starts with it; gaps keep their length
        rows: list[FloatArray] = []
        begins: list[int] = []
        n_joined = 0
        for piece, conversion in zip(pieces, conversions, strict=True):
            lacking = max(round(piece[0] * ratio) - n_joined, 0)
            begins.append(n_joined + lacking)
            rows += [np.full((lacking, inputs.shape[1]), np.nan), conversion.network_rates_rad_s]
            n_joined = begins[-1] + len(rows[-1])
        joined = np.concatenate(rows) if rows else np.empty((0, inputs.shape[1]))
        tracked = self._at_network_rate_tracked(joined, signals.initial_angles_rad)
        angles, std, corrected = np.full((3, n, 3), np.nan)
        growth, by_network = np.full(n, np.nan), np.zeros(n, dtype=bool)
        for piece, begin, conversion in zip(pieces, begins, conversions, strict=True):
            part = slice(begin, begin + len(conversion.network_rates_rad_s))
            angles[piece] = conversion.to_recording(tracked.angles_rad[part])
            nearest = np.round(np.arange(len(piece)) * ratio).astype(int)
            nearest = np.minimum(begin + nearest, part.stop - 1)
            std[piece], by_network[piece] = tracked.std_rad[nearest], tracked.by_network[nearest]
            growth[piece] = tracked.std_growth[nearest]
            corrected[piece] = tracked.corrected_rad[nearest]
        return Tracked(angles, std, growth, corrected, by_network)

    def _at_network_rate_tracked(self, inputs: FloatArray, start: FloatArray | None) -> Tracked:
        tracking = Tracking(self.tracker, self.model, start)
        return follow(tracking, inputs, self.tracker.aided, self.smoothing)

    def recursion(
        self, sampling_rate_hz: float, n_sensors: int, initial_angles_rad: FloatArray | None
    ) -> Recursion:
        """Start the method for use sample by sample (`narx.inference.stream`).

        Parameters
        ----------
        sampling_rate_hz : float
            Sampling rate, which must be the network's.
        n_sensors : int
            Number of sensors that run in parallel.
        initial_angles_rad : ndarray, shape (n_sensors, 3), optional
            Known start poses; None if they are unknown.

        Returns
        -------
        Recursion
            Recursion that gives the same angles as `estimate`; missing samples advance its time.

        Raises
        ------
        MethodNotApplicableError
            If the rate is not the network's, or with smoothing.
        """
        if not np.isclose(sampling_rate_hz, self.model.sampling_rate_hz, rtol=1e-6):
            raise MethodNotApplicableError(
                f"narx: this network runs sample by sample at {self.model.sampling_rate_hz:g} Hz, "
                f"not at {sampling_rate_hz:g} Hz"
            )
        if self.smoothing:
            raise MethodNotApplicableError(
                "narx: smoothing needs the whole recording, use smoothing=false"
            )
        return TrackedRecursion(self.tracker, self.model, n_sensors, initial_angles_rad)
