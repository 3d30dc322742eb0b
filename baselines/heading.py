"""Treatment of the heading, which gravity does not determine.

With gyroscope and accelerometer, the tilt is observable but the heading is not: it drifts
differently in thigh and shank, which affects all angles of the knee. The treatment of the heading
is therefore separate from the method, and the same for all methods.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from narx.errors import MethodNotApplicableError, UserError
from narx.inference.start_up import StartUp
from narx.kinematics.segment_angles import TRANSVERSE, coupled_rates
from narx.types import FloatArray

TREATMENTS = ("own", "zero", "leak")


@dataclass(frozen=True)
class Heading:
    """Treatment of the transverse angle.

    Parameters
    ----------
    treatment : {"own", "zero", "leak"}
        ``own``: as estimated by the method, possibly NaN. ``zero``: no heading. ``leak``: the
        method's changes of heading, or, if it has none, those of the gyroscope at its tilt,
        integrated with a leak.
    leak_rad_s : float
        Leak of the treatment ``leak``, rad/s.

    Raises
    ------
    UserError
        If the treatment is unknown or the leak not positive.
    """

    treatment: str = "own"
    leak_rad_s: float = 0.3

    def __post_init__(self) -> None:
        if self.treatment not in TREATMENTS:
            raise UserError(
                f"heading is '{self.treatment}', expected one of {', '.join(TREATMENTS)}"
            )
        if not (np.isfinite(self.leak_rad_s) and self.leak_rad_s > 0):
            raise UserError(f"heading_leak_rad_s is {self.leak_rad_s}, expected a positive number")

    def refuse_stream(self, method: str) -> None:
        """Refuse to run sample by sample if the treatment needs whole recordings.

        Parameters
        ----------
        method : str
            Name, for the message.

        Raises
        ------
        MethodNotApplicableError
            If the treatment is not ``own``.
        """
        if self.treatment != "own":
            raise MethodNotApplicableError(
                f"method {method}: heading={self.treatment} is for whole recordings; "
                "heading=own runs sample by sample"
            )

    def of(
        self,
        angles_rad: FloatArray,
        axis_rates_rad_s: FloatArray,
        interval_s: float,
        initial_angles_rad: FloatArray | None,
        start_up: StartUp | None = None,
    ) -> FloatArray:
        """Treat the heading of a recording.

        Parameters
        ----------
        angles_rad : ndarray, shape (N, 3)
            The method's angles; the transverse one is NaN if it has none.
        axis_rates_rad_s : ndarray, shape (N, 3)
            Gyroscope about the clinical axes, rad/s.
        interval_s : float
            Sampling interval, s.
        initial_angles_rad : ndarray, shape (3,), optional
            Known start pose.
        start_up : StartUp, optional
            With ``leak``: its heading is used at the start, and the leak is towards its posture.

        Returns
        -------
        ndarray, shape (N, 3)
            Angles with the treated transverse angle, rad.
        """
        if self.treatment == "own" or not len(angles_rad):
            return angles_rad
        angles = angles_rad.copy()
        if self.treatment == "zero":
            angles[:, TRANSVERSE] = 0.0
            return angles
        change = np.diff(angles_rad[:, TRANSVERSE], prepend=angles_rad[:1, TRANSVERSE])
        if np.isnan(change).all():
            rates = coupled_rates(axis_rates_rad_s, angles_rad)[:, TRANSVERSE]
            change = np.concatenate([[0.0], 0.5 * interval_s * (rates[1:] + rates[:-1])])
        first, posture = np.empty(0), 0.0
        deviation = 0.0 if initial_angles_rad is None else float(initial_angles_rad[TRANSVERSE])
        if start_up is not None:
            state = start_up.begin(initial_angles_rad)
            first = start_up.run(axis_rates_rad_s, interval_s, state)[:, TRANSVERSE]
            if len(first):
                hand_over = StartUp.hand_over(state, interval_s)
                posture, deviation = (float(part[TRANSVERSE]) for part in hand_over[:2])
        kept = 1.0 / (1.0 + interval_s * self.leak_rad_s)
        rest, _ = lfilter([kept], [1.0, -kept], change[len(first) :], zi=[kept * deviation])
        angles[:, TRANSVERSE] = np.concatenate([first, posture + rest])
        return angles
