"""First-order complementary filter: the gyroscope above a crossover, the accelerometer below."""

from collections.abc import Sequence

import numpy as np

from narx.baselines.parameters import one_of, positive, tilt_axes
from narx.errors import UserError
from narx.kernels.gravity import complementary, complementary_step, tilt
from narx.kinematics.segment_angles import FRONTAL, tilt_from_specific_force
from narx.method import OrientationMethod, SegmentSignals, Step
from narx.types import FloatArray


class ComplementaryFilter(OrientationMethod):
    """Integrate the gyroscope and pull the angle towards the accelerometer's tilt.

    Parameters
    ----------
    crossover_hz : float
        Frequency at which both sensors weigh the same, Hz.
    rule : {"trapezoid", "rectangle"}
        How the rate goes between two samples: straight from one to the next, or the later value
        all the way (Abhayasinghe et al., eq. (3), as printed; it runs half a sample ahead).
    axes : sequence of str
        ``sagittal``, ``frontal`` or both. What is left out, and the transverse axis, which
        gravity does not show, is NaN.

    Notes
    -----
    Tham et al., eq. (3): ``P(s) = wc / (s + wc) A(s) + 1 / (s + wc) N(s)`` with the tilt ``A``
    from the accelerometer, the rate ``N`` and ``wc = 2 pi crossover_hz``. Discretised with
    ``alpha = 1 / (1 + wc Ts)`` this is Abhayasinghe et al., eq. (3):
    ``p_k = alpha (p_{k-1} + v_k Ts) + (1 - alpha) a_k``, so both papers' filters are this one.
    The difference between accelerometer and prediction is taken along the shorter way round, so
    that an accelerometer angle that jumps from +180 to -180 degrees does not pull the estimate
    through zero.
    """

    name = "complementary_filter"
    needs_accelerometer = True
    streams = True

    def __init__(
        self,
        crossover_hz: float = 0.1,
        rule: str = "trapezoid",
        axes: Sequence[str] = ("sagittal", "frontal"),
    ) -> None:
        self.crossover_hz = positive(self.name, "crossover_hz", crossover_hz)
        self.rule = one_of(self.name, "rule", rule, ("trapezoid", "rectangle"))
        self.columns = tilt_axes(self.name, axes)

    @classmethod
    def from_alpha(
        cls,
        alpha: float,
        sampling_rate_hz: float,
        rule: str = "rectangle",
        axes: Sequence[str] = ("sagittal", "frontal"),
    ) -> "ComplementaryFilter":
        """Make the filter of Abhayasinghe et al., eq. (3), from its coefficient.

        Parameters
        ----------
        alpha : float
            Weight of the gyroscope's prediction, between 0 and 1; the paper's are 0.9999
            offline and 0.999 in real time.
        sampling_rate_hz : float
            Rate for which `alpha` was meant (the paper's: 100). At another rate the filter
            keeps its crossover, not its `alpha`.
        rule : {"trapezoid", "rectangle"}
            As in the class; the paper's is the rectangle.
        axes : sequence of str
            As in the class.

        Returns
        -------
        ComplementaryFilter
            With ``crossover_hz = (1 / alpha - 1) * sampling_rate_hz / (2 pi)``.

        Raises
        ------
        UserError
            If `alpha` is not between 0 and 1.
        """
        if not 0.0 < alpha < 1.0:
            raise UserError(f"method {cls.name}: alpha is {alpha}, expected 0 < alpha < 1")
        crossover_hz = (1.0 / alpha - 1.0) * sampling_rate_hz / (2.0 * np.pi)
        return cls(crossover_hz, rule, axes)

    def alpha(self, sampling_rate_hz: float) -> float:
        """Coefficient of Abhayasinghe et al., eq. (3), at a sampling rate.

        Parameters
        ----------
        sampling_rate_hz : float
            Sampling rate.

        Returns
        -------
        float
            ``1 / (1 + 2 pi crossover_hz / sampling_rate_hz)``.
        """
        return 1.0 / (1.0 + 2.0 * np.pi * self.crossover_hz / sampling_rate_hz)

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        initial = signals.initial_angles_rad
        angles = np.full((signals.n_samples, 3), np.nan)
        tilts = tilt_from_specific_force(signals.specific_force_m_s2)
        gain = 1.0 - self.alpha(signals.sampling_rate_hz)
        for axis in self.columns:
            angles[:, axis] = complementary(
                np.ascontiguousarray(signals.axis_rates_rad_s[:, axis]),
                np.ascontiguousarray(tilts[:, axis]),
                0.0 if initial is None else float(initial[axis]),
                signals.interval_s,
                gain,
                self.rule == "trapezoid",
            )
        return angles

    def _stream(self, sampling_rate_hz: float) -> Step:
        interval_s = 1.0 / sampling_rate_hz
        gain = 1.0 - self.alpha(sampling_rate_hz)
        trapezoid = self.rule == "trapezoid"
        angles = [np.nan, np.nan, np.nan]
        for axis in self.columns:
            angles[axis] = 0.0
        before: list[float] | None = None

        def step(axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
            nonlocal before
            rates = [axis_rates[0], axis_rates[1], axis_rates[2]]
            if before is not None:
                x, y, z = specific_force
                for axis in self.columns:
                    angles[axis] = complementary_step(
                        angles[axis],
                        rates[axis],
                        before[axis],
                        tilt(axis == FRONTAL, x, y, z),
                        interval_s,
                        gain,
                        trapezoid,
                    )
            before = rates
            return np.array(angles)

        return step
