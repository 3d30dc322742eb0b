"""Errors that the user can correct; commands print them in one line and exit with status 2."""

import re

# also those of str.splitlines, by which a log or a table may be cut
_LINE_BREAK = re.compile("[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]+")


# a value that is quoted may be a whole file
_BEGINNING, _END = 1500, 500


class UserError(Exception):
    """An input is wrong; the message names where, what was found and what is expected.

    It is one line: breaks in it, as from a name in a damaged file, are shown as blanks. Of more
    than 2000 letters, those in the middle are left out.
    """

    def __str__(self) -> str:
        line = _LINE_BREAK.sub(" ", super().__str__())
        if len(line) <= _BEGINNING + _END:
            return line
        return f"{line[:_BEGINNING]} ... {line[-_END:]}"


class RecordingError(UserError):
    """A recording, or a file that should contain one, is invalid."""


class MethodNotApplicableError(UserError):
    """A method requires something that is not available (a still part, a library)."""


def user_error_behind(error: BaseException | None) -> UserError | None:
    """Find the user error that caused an exception.

    Parameters
    ----------
    error : BaseException or None
        Possibly raised by a library while it handled the user error.

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
