"""What the adapters to full orientation filters share: signals in, three angles out."""

import numpy as np
from numpy.typing import ArrayLike

from narx.kinematics.segment_angles import TRANSVERSE, angles_from_orientation
from narx.method import SegmentSignals
from narx.types import FloatArray


def angles_of(quaternion_wxyz: FloatArray, signals: SegmentSignals) -> FloatArray:
    """Turn a filter's orientations into angles whose heading starts where the segment does.

    Parameters
    ----------
    quaternion_wxyz : ndarray, shape (N, 4)
        Orientation of the anatomical frame against a world with z up and any heading.
    signals : SegmentSignals
        For the heading at the first sample; zero where it is not known.

    Returns
    -------
    ndarray, shape (N, 3)
        Angles in rad. Without a magnetometer a filter's heading is arbitrary, so the transverse
        angle is counted from the first sample.
    """
    if not len(quaternion_wxyz):
        return np.empty((0, 3))
    angles = angles_from_orientation(quaternion_wxyz)
    initial = signals.initial_angles_rad
    first = 0.0 if initial is None else float(initial[TRANSVERSE])
    angles[:, TRANSVERSE] += first - angles[0, TRANSVERSE]
    return angles


class AnglesOneByOne:
    """The same as `angles_of`, from zero heading, one orientation at a time."""

    def __init__(self) -> None:
        self._offset: float | None = None
        self._heading = 0.0

    def __call__(self, quaternion_wxyz: ArrayLike) -> FloatArray:
        """Turn the next orientation into angles.

        Parameters
        ----------
        quaternion_wxyz : array_like, shape (4,)
            Orientation of the anatomical frame against a world with z up.

        Returns
        -------
        ndarray, shape (3,)
            Angles in rad, the heading without jumps.
        """
        angles = angles_from_orientation(quaternion_wxyz)[0]
        if self._offset is None:
            self._offset = float(angles[TRANSVERSE])
        change = angles[TRANSVERSE] - self._offset - self._heading
        self._heading += change - 2.0 * np.pi * np.round(change / (2.0 * np.pi))
        angles[TRANSVERSE] = self._heading
        return angles
