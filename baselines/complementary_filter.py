"""First-order complementary filter: gyroscope above a crossover frequency, accelerometer below."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from narx.baselines.heading import Heading
from narx.baselines.parameters import both_if_coupled, one_of, positive, tilt_axes
from narx.baselines.recursive import Constants, GivenStartUp, Inputs, RecursiveMethod
from narx.errors import UserError
from narx.kernels.gravity import tilt
from narx.kernels.recursions import pull
from narx.kinematics.segment_angles import FRONTAL, TRANSVERSE, tilt_from_specific_force
from narx.method import SegmentSignals
from narx.types import FloatArray


class ComplementaryFilter(RecursiveMethod):
    """Integrate the gyroscope and pull the angle towards the accelerometer's tilt.

    Parameters
    ----------
    crossover_hz : float
        Frequency at which both sensors have equal weight, Hz.
    rule : {"trapezoid", "rectangle"}
        Rate between two samples: linear, or constant at the later value (Abhayasinghe et al., eq.
        (3), as printed; it is half a sample ahead).
    axes : sequence of str
        ``sagittal``, ``frontal`` or both. The others are NaN, as is the transverse axis, which is
        not observable from gravity.
    coupled, start_up, washout_s, smoothing
        As in `narx.baselines.recursive.RecursiveMethod`.
    heading, heading_leak_rad_s
        As `treatment` and `leak_rad_s` of `narx.baselines.heading.Heading`.

    Notes
    -----
    Tham et al., eq. (3): ``P(s) = wc / (s + wc) A(s) + 1 / (s + wc) N(s)`` with the tilt ``A``
    from the accelerometer, the rate ``N`` and ``wc = 2 pi crossover_hz``. Discretised with
    ``alpha = 1 / (1 + wc Ts)``, it is Abhayasinghe et al., eq. (3):
    ``p_k = alpha (p_{k-1} + v_k Ts) + (1 - alpha) a_k``, so both papers use the same filter.
    The difference between accelerometer and prediction is wrapped to half a turn, so that a jump of
    the accelerometer angle from +180 to -180 degrees does not affect the estimate.
    """

    name = "complementary_filter"
    needs_accelerometer = True
    _recursion = pull

    def __init__(
        self,
        crossover_hz: float = 0.1,
        rule: str = "trapezoid",
        axes: Sequence[str] = ("sagittal", "frontal"),
        coupled: bool = False,
        start_up: GivenStartUp = None,
        washout_s: float | None = None,
        smoothing: bool = False,
        heading: str = "own",
        heading_leak_rad_s: float = 0.3,
    ) -> None:
        super().__init__(coupled, start_up, washout_s, smoothing)
        self.crossover_hz = positive(self.name, "crossover_hz", crossover_hz)
        self.rule = one_of(self.name, "rule", rule, ("trapezoid", "rectangle"))
        self.columns = both_if_coupled(self.name, tilt_axes(self.name, axes), coupled)
        self.heading = Heading(heading, heading_leak_rad_s)

    @classmethod
    def from_alpha(
        cls,
        alpha: float,
        sampling_rate_hz: float,
        rule: str = "rectangle",
        axes: Sequence[str] = ("sagittal", "frontal"),
    ) -> "ComplementaryFilter":
        """Create the filter of Abhayasinghe et al., eq. (3), from its coefficient.

        Parameters
        ----------
        alpha : float
            Weight of the gyroscope's prediction, between 0 and 1; the paper's are 0.9999
            offline and 0.999 in real time.
        sampling_rate_hz : float
            Rate for which `alpha` is given (in the paper: 100). At other sampling rates the filter
            keeps its crossover frequency, not its `alpha`.
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

    def _parameters(self, interval_s: float) -> Constants:
        return interval_s, float(self.rule == "trapezoid"), 1.0 - self.alpha(1.0 / interval_s)

    @property
    def _extras_are_angles(self) -> bool:
        return True

    def _inputs(self, signals: SegmentSignals) -> tuple[FloatArray, FloatArray]:
        tilts = np.full((signals.n_samples, 3), np.nan)
        tilts[:, :TRANSVERSE] = tilt_from_specific_force(signals.specific_force_m_s2)
        return signals.axis_rates_rad_s, tilts

    def _inputs_one_by_one(self, sampling_rate_hz: float) -> Inputs:
        return _TiltInputs(self.columns)


@dataclass
class _TiltInputs:
    columns: Sequence[int]

    def __call__(
        self, axis_rates: FloatArray, specific_force: FloatArray
    ) -> tuple[FloatArray, Sequence[Any]]:
        tilts: list[Any] = [np.nan] * 3
        for axis in self.columns:
            tilts[axis] = tilt(axis == FRONTAL, *specific_force)
        return axis_rates, tilts
