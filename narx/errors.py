"""Errors that are the user's to mend; every command prints them in one line and ends with 2."""


class UserError(Exception):
    """Something outside the program is wrong: say where, what was found, what was expected."""


class RecordingError(UserError):
    """A recording, or a file that should hold one, is not what it must be."""


class MethodNotApplicableError(UserError):
    """A method needs something that this recording does not have (a still part, a library)."""
