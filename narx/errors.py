"""Errors that are the user's to mend; every command prints them in one line and ends with 2."""


class UserError(Exception):
    """Something outside the program is wrong: say where, what was found, what was expected."""


class RecordingError(UserError):
    """A recording, or a file that should hold one, is not what it must be."""


class MethodNotApplicableError(UserError):
    """A method needs something that this recording does not have (a still part, a library)."""


def user_error_behind(error: BaseException | None) -> UserError | None:
    """Find the user's mistake that an exception comes from.

    Parameters
    ----------
    error : BaseException or None
        Perhaps raised by a library while it handled the mistake.

    Returns
    -------
    UserError or None
        First in the chain of causes.
    """
    while error is not None:
        if isinstance(error, UserError):
            return error
        error = error.__cause__ or error.__context__
    return None
