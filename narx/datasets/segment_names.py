"""Recognise the segment in the name of a tracked point, a column or a file."""

import re

from narx.files import safe_name
from narx.recordings.trial import kind_of

_PARTS = {
    "thigh": ("thigh", "upperleg", "upleg", "femur"),
    "shank": ("shank", "lowerleg", "tibia", "shin", "calf"),
    "pelvis": ("pelvis", "sacrum", "sacral"),
    "foot": ("foot",),
}
_SIDES = {"left": ("left", "l"), "right": ("right", "r")}
_PART = "|".join(spelling for known in _PARTS.values() for spelling in known)
_SIDE = "|".join(spelling for known in _SIDES.values() for spelling in known)
# a body part, with the side after it or else before it, as it occurs within a file name
_SIDE_AFTER = rf"[ _.-]?(?:{_SIDE})(?![a-z])"
SEGMENT_PATTERN = (
    rf"(?:(?<![a-z0-9])(?:{_SIDE})[ _.-]?(?:{_PART})(?!{_SIDE_AFTER})"
    rf"|(?:{_PART})(?:{_SIDE_AFTER})?)"
)


def segment_of(name: str) -> str:
    """Guess the segment from a name.

    Parameters
    ----------
    name : str
        Such as ``LeftThigh``, ``shank_r``, ``RThigh``, ``RightUpperLeg`` or ``pelvis``.

    Returns
    -------
    str
        Body part and side if both are recognised (``thigh_left``), the body part alone without a
        side, otherwise the name itself, made safe for a file name.
    """
    spaced = re.sub(r"([a-z])([A-Z])", r"\1 \2", name)
    spaced = re.sub(r"([A-Z])([A-Z][a-z])", r"\1 \2", spaced)
    words = re.findall(r"[a-z]+", spaced.lower())
    joined = "".join(words)
    part = next((part for part, known in _PARTS.items() if any(k in joined for k in known)), None)
    if part is None:
        return safe_name(name)
    rest = joined
    for known in _PARTS[part]:
        rest = rest.replace(known, "")
    for side, spellings in _SIDES.items():
        # a single letter is a side if it is separate, or directly before the part: lthigh
        if spellings[0] in joined or spellings[1] in words or rest == spellings[1]:
            return f"{part}_{side}"
    return part


def segment_in_name(name: str) -> str | None:
    """Find a segment in a name.

    Parameters
    ----------
    name : str
        As for `segment_of`.

    Returns
    -------
    str or None
        None if the name contains no known body part.
    """
    segment = segment_of(name)
    return segment if kind_of(segment) in _PARTS else None
