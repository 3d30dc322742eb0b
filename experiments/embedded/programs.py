"""Compilers and simulators, which are not Python packages."""

import shutil
from collections.abc import Sequence

AVR = ("avr-gcc", "avr-size", "simavr")
CORTEX = ("arm-none-eabi-gcc", "qemu-system-arm")


def missing(programs: Sequence[str]) -> list[str]:
    """List programs that are not installed.

    Parameters
    ----------
    programs : sequence of str
        `AVR` or `CORTEX`.

    Returns
    -------
    list of str
        Their names.
    """
    return [name for name in programs if shutil.which(name) is None]
