"""Start of a command: its modules are imported, which takes seconds, before its own code runs.

Until then, Ctrl-C would end in a traceback of an import, and the garbage collector would search
some hundred thousand objects that stay, again and again. Afterwards, Ctrl-C raises as usual, and is
remembered: code that is interrupted while it cleans up may raise another exception instead.
"""

import contextlib
import gc
import io
import os
import select
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

INTERRUPTED_STATUS = 130  # the status that a shell reports for a process ended by Ctrl-C
_CLOSED_PIPE_STATUS = 141  # and for one that wrote to a pipe without a reader
_PREFIX = "narx-"  # of the console scripts
_WORKERS = "loky"  # in the command line of joblib's
_paused = False
_reacting = False
_pressed = False


def begin() -> None:
    """Until `imported`, pause the garbage collector, and end in one line on Ctrl-C.

    A worker ignores Ctrl-C, since the command ends it. All other processes are left as they are.
    """
    if any(_WORKERS in argument for argument in sys.orig_argv):
        _react(signal.SIG_IGN)
        return
    if not _is_command():
        return
    global _paused
    _paused = gc.isenabled()
    gc.disable()
    # figures are only written to files; matplotlib would refuse the name of an unknown backend
    os.environ["MPLBACKEND"] = "agg"
    # names of files may have letters that a terminal's encoding does not
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    _react(_end)


def imported() -> None:
    """Restore the garbage collector and the reaction to Ctrl-C."""
    global _paused, _reacting
    if _paused:
        gc.freeze()  # modules stay until the end
        gc.enable()
        _paused = False
    if _reacting:
        signal.signal(signal.SIGINT, _interrupt)
        _reacting = False


@contextlib.contextmanager
def pipe_may_close() -> Iterator[None]:
    """End the process without a message if nobody reads what it prints, as with ``| head``.

    Yields
    ------
    None
        The command runs meanwhile.
    """
    try:
        try:
            yield
        finally:
            sys.stdout.flush()
    except BrokenPipeError as error:
        end_if_output_is_closed(error)
        raise


def end_if_output_is_closed(error: BaseException) -> None:
    """End the process without a message, as Unix tools do, if an error is that of a closed pipe.

    Parameters
    ----------
    error : BaseException
        Another error, or of another pipe than the standard output, is left to the caller.
    """
    if not isinstance(error, BrokenPipeError) or sys.platform == "win32":
        return
    poll = select.poll()
    poll.register(sys.stdout, 0)
    if poll.poll(0):  # no condition was asked for: only errors are reported
        # what is still in the buffer is written at the end of the process
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(_CLOSED_PIPE_STATUS)


def interrupted() -> bool:
    """Tell whether Ctrl-C was pressed since the imports.

    Returns
    -------
    bool
        False in a process that is not one of the commands.
    """
    return _pressed


def _react(handler: Any) -> None:
    global _reacting
    # the signal remains ignored in the background
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, handler)
        _reacting = True


def _is_command() -> bool:
    script = sys.argv[0]
    # "-m" while Python looks for the module. A launcher's workers have the arguments of their
    # parent in sys.argv, but not in sys.orig_argv
    return script == "-m" or (script in sys.orig_argv and Path(script).name.startswith(_PREFIX))


def _end(number: int, frame: FrameType | None) -> None:
    os.write(2, b"\ninterrupted: nothing has begun; repeat the command to start again\n")
    os._exit(INTERRUPTED_STATUS)  # code that is being imported may catch an exception


def _interrupt(number: int, frame: FrameType | None) -> None:
    global _pressed
    _pressed = True
    raise KeyboardInterrupt
