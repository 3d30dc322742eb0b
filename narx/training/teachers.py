"""Sources of the target angles of training."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from narx.calibration.calibrate import CalibratedSegment
from narx.errors import UserError
from narx.method import OrientationMethod
from narx.types import FloatArray


@runtime_checkable
class Teacher(Protocol):
    """Source of target angles."""

    def angles_rad(self, dataset: str, segment: CalibratedSegment) -> FloatArray:
        """Return the target angles of a segment.

        Parameters
        ----------
        dataset : str
            Dataset of the segment.
        segment : CalibratedSegment
            Segment to learn.

        Returns
        -------
        ndarray, shape (N, 3)
            Angles in rad; NaN where there is no target.
        """
        ...


@dataclass(frozen=True)
class MethodTeacher:
    """Learn from another method: the complementary filter of Tham et al., or VQF.

    Parameters
    ----------
    method : OrientationMethod
        The teacher.
    """

    method: OrientationMethod

    def angles_rad(self, dataset: str, segment: CalibratedSegment) -> FloatArray:
        """Estimate the angles.

        Parameters
        ----------
        dataset : str
            Not used.
        segment : CalibratedSegment
            Segment to learn.

        Returns
        -------
        ndarray, shape (N, 3)
            Angles in rad.
        """
        return self.method.estimate(segment.signals)


@dataclass(frozen=True)
class ReferenceTeacher:
    """Learn from the optical reference of the training trials."""

    def angles_rad(self, dataset: str, segment: CalibratedSegment) -> FloatArray:
        """Return the reference angles.

        Parameters
        ----------
        dataset : str
            Dataset, for the message.
        segment : CalibratedSegment
            Segment to learn.

        Returns
        -------
        ndarray, shape (N, 3)
            Angles in rad.

        Raises
        ------
        UserError
            If the segment has no reference.
        """
        if segment.reference_angles_rad is None:
            raise UserError(
                f"teacher: '{segment.signals.segment}' of {dataset} has no reference; "
                "use teacher=complementary_filter"
            )
        return segment.reference_angles_rad


@dataclass(frozen=True)
class AutomaticTeacher:
    """Learn from the method in simulation, as in the paper, and otherwise from the reference.

    On real walks with turns the complementary filter, which treats the axes independently, is too
    inaccurate as a teacher (docs/generalisation.md).

    Parameters
    ----------
    method : OrientationMethod
        Teacher in simulation, and for segments without a reference.
    """

    method: OrientationMethod

    def angles_rad(self, dataset: str, segment: CalibratedSegment) -> FloatArray:
        """Estimate the angles or return those of the reference.

        Parameters
        ----------
        dataset : str
            Dataset of the segment.
        segment : CalibratedSegment
            Segment to learn.

        Returns
        -------
        ndarray, shape (N, 3)
            Angles in rad.
        """
        if dataset == "simulated_gait" or segment.reference_angles_rad is None:
            return self.method.estimate(segment.signals)
        return segment.reference_angles_rad
