"""Names of the columns of angles: which segment or joint, about which axis."""

import re
from dataclasses import dataclass

from narx.kinematics.segment_angles import AXES

_NAME = re.compile(rf"(?:(\w+)_)?({'|'.join(AXES)})(_std)?_deg")


@dataclass(frozen=True)
class AngleColumn:
    """What a column holds, in degrees.

    Parameters
    ----------
    point : str
        Segment or joint.
    axis : str
        Clinical axis.
    is_std : bool
        Whether it is the standard deviation of the angle.
    """

    point: str
    axis: str
    is_std: bool


def angle_column(name: str, alone: str = "segment") -> AngleColumn | None:
    """Parse the name of a column.

    Parameters
    ----------
    name : str
        Such as ``knee_right_sagittal_deg`` or ``sagittal_std_deg``.
    alone : str
        The segment, where a single one is predicted and the columns do not name it.

    Returns
    -------
    AngleColumn or None
        None for other columns.
    """
    found = _NAME.fullmatch(name)
    return AngleColumn(found[1] or alone, found[2], bool(found[3])) if found else None
