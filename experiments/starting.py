"""Start of a command: its modules are imported, which takes seconds, before its own code runs.

Until then, Ctrl-C would end in a traceback of an import, and the garbage collector would search
some hundred thousand objects that stay, again and again.
"""

import gc
import os
import signal
import sys
from pathlib import Path
from types import FrameType

INTERRUPTED_STATUS = 130  # the status that a shell reports for a process ended by Ctrl-C
_PREFIX = "narx-"  # of the console scripts
_paused = False


def begin() -> None:
    """Until `imported`, pause the garbage collector, and end in one line on Ctrl-C.

    It has no effect in a process that is not one of the commands.
    """
    if not _is_command():
        return
    global _paused
    _paused = gc.isenabled()
    gc.disable()
    # the signal remains ignored in the background
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def imported() -> None:
    """Restore the garbage collector and the reaction to Ctrl-C."""
    global _paused
    if _paused:
        gc.freeze()  # modules stay until the end
        gc.enable()
        _paused = False
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _is_command() -> bool:
    script = sys.argv[0]
    # "-m" while Python looks for the module. A launcher's workers have the arguments of their
    # parent in sys.argv, but not in sys.orig_argv
    return script == "-m" or (script in sys.orig_argv and Path(script).name.startswith(_PREFIX))


def _end(number: int, frame: FrameType | None) -> None:
    os.write(2, b"\ninterrupted: nothing has begun; repeat the command to start again\n")
    os._exit(INTERRUPTED_STATUS)  # code that is being imported may catch an exception
