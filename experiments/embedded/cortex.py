"""Instructions of a method on Cortex-M processors, counted by qemu."""

import re
import subprocess
import tempfile
from collections.abc import Mapping
from importlib import resources
from pathlib import Path

import numpy as np

from narx.errors import UserError
from narx.types import FloatArray

# compiler's options, qemu's board, nanoseconds of its SysTick: an instruction takes one
PROCESSORS: dict[str, tuple[tuple[str, ...], str, float]] = {
    "Cortex-M0+": (("-mcpu=cortex-m0plus",), "microbit", 62.5),
    "Cortex-M4F": (
        ("-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"), "mps2-an386", 40.0,
    ),
}  # fmt: skip
_FLAGS = ("-mthumb", "-O2", "-std=c99", "-Wall", "-Wextra", "-nostartfiles", "--specs=nosys.specs")
_QEMU = (
    "qemu-system-arm", "-nographic", "-monitor", "none", "-serial", "none", "-icount", "shift=0",
    "-semihosting-config", "enable=on,target=native", "-kernel", "bench.elf", "-machine",
)  # fmt: skip


def count(
    sources: Mapping[str, str], processor: str, defines: tuple[str, ...] = ()
) -> tuple[FloatArray, FloatArray]:
    """Compile a method with the harness and run it in qemu.

    Parameters
    ----------
    sources : mapping of str to str
        Files with ``bench_start`` and ``bench_step``, and ``signal.h``.
    processor : str
        One of `PROCESSORS`.
    defines : tuple of str
        Options of the compiler.

    Returns
    -------
    instructions : ndarray, shape (N,)
        Of each sample, in steps of SysTick.
    angle_rad : ndarray, shape (N,)
        First angle.

    Raises
    ------
    UserError
        If the program does not reach its end.
    """
    options, board, step = PROCESSORS[processor]
    package = resources.files("narx.experiments.embedded")
    harness = {name: (package / name).read_text("utf-8") for name in ("cortex.c", "cortex.ld")}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, content in {**sources, **harness}.items():
            (folder / file).write_text(content, encoding="utf-8")
        units = [file for file in (*sources, "cortex.c") if file.endswith(".c")]
        command = ["arm-none-eabi-gcc", *options, *_FLAGS, *defines, "-T", "cortex.ld", *units]
        subprocess.run(
            [*command, "-o", "bench.elf", "-lm"], cwd=folder, check=True, capture_output=True
        )
        run = subprocess.run(
            [*_QEMU, board], cwd=folder, check=False, capture_output=True, text=True, timeout=300
        )
    found = re.findall(r"([0-9a-f]{8}) ([0-9a-f]{8})\n", run.stdout + run.stderr)
    if run.returncode or not found:
        raise UserError(f"qemu-system-arm: {processor} ended after {len(found)} samples")
    steps, bits = (np.array([int(pair[i], 16) for pair in found], dtype=np.uint32) for i in (0, 1))
    instructions: FloatArray = steps.astype(np.float64) * step
    return instructions, bits.view(np.float32).astype(np.float64)
