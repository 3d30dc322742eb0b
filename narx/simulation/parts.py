"""Parts of a walk in which something happens, as a user gives them."""

from collections.abc import Sequence

from narx.errors import UserError


def check_parts(
    name: str,
    parts_s: Sequence[tuple[float, float]],
    protocol: str,
    least_s: float,
    first_s: float,
    last_s: float,
) -> None:
    """Refuse parts that a walk has no room for.

    Parameters
    ----------
    name : str
        Of the option, for the message.
    parts_s : sequence of tuple of (float, float)
        Begin and end of each, s.
    protocol : str
        Of the recording.
    least_s : float
        Shortest part, s.
    first_s, last_s : float
        Full steps from then on, and end of the recording, s.

    Raises
    ------
    UserError
        If the walk is not on a treadmill, or a part is too short, overlaps the one before, or is
        outside.
    """
    if parts_s and protocol != "treadmill":
        raise UserError(f"{name} is for protocol=treadmill, found protocol={protocol}")
    before_s = first_s
    for begin, end in parts_s:
        if not (before_s <= begin and begin + least_s <= end <= last_s):
            raise UserError(
                f"{name} has [{begin:g}, {end:g}], expected parts of at "
                f"least {least_s:g} s, one after another, from {first_s:g} to {last_s:g} s"
            )
        before_s = end
