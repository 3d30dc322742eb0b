"""Start of a command: its modules are imported, which takes seconds, before its own code runs.

Until then, Ctrl-C would end in a traceback of an import, and the garbage collector would search
some hundred thousand objects that stay, again and again. Afterwards, Ctrl-C raises as usual, and is
remembered: code that is interrupted while it cleans up may raise another exception instead.
"""

import gc
import os
import signal
import sys
from pathlib import Path
from types import FrameType
from typing import Any

INTERRUPTED_STATUS = 130  # the status that a shell reports for a process ended by Ctrl-C
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
