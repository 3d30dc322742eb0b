"""Compile the exported network and its rivals for an ATmega328P, run them, and print the table.

python -m experiments.embedded

Needs avr-gcc, avr-libc and simavr (Debian: gcc-avr avr-libc simavr); without them one line says so.
Where arm-none-eabi-gcc and qemu-system-arm are installed, instructions on a Cortex-M are counted.
"""

import argparse
import re
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path

import numpy as np
import torch

from narx.baselines import ComplementaryFilter, Giof, PseudoIntegrator, TwoPoint
from narx.baselines.two_point import TwoPointParts
from narx.errors import UserError
from narx.experiments.embedded import cortex, programs
from narx.experiments.starting import imported
from narx.export import c, verification
from narx.inference.checkpoint import Checkpoint
from narx.inference.pretrained import pretrained
from narx.inference.start_up import StartUp
from narx.method import OrientationMethod, SegmentSignals
from narx.network.model import Narx
from narx.recordings.trial import GRAVITY_M_S2
from narx.types import FloatArray

CLOCK_HZ, TIMER_CYCLES = 8e6, 8
RATE_HZ = 100.0
# Abhayasinghe et al., Table 2, us on the same processor
PAPERS_US = {"complementary filter": "570", "GIOF": "225 to 500"}
_FLAGS = ("-mmcu=atmega328p", "-DF_CPU=8000000UL", "-Os", "-mrelax", "-std=c99", "-Wall", "-Wextra")
# standing before and after the walk
_STANDS_S = 1.0, 5.5
_SECONDS, _ALPHA, _PSEUDO_HZ, _ETA_M_S2, _REST_DEG_S = 6.0, 0.999, 0.9, 0.2, 5.0


@dataclass(frozen=True)
class Cost:
    """What a method needs.

    Parameters
    ----------
    mean_us, worst_us : float
        Time of a sample at 8 MHz.
    flash_bytes, ram_bytes : int
        Program without the signal and the harness's own; static memory.
    difference_rad : float
        Largest difference from the package, on any of the processors.
    instructions : dict of str to float
        Mean of a sample, by processor of `cortex.PROCESSORS`; empty without its programs.
    """

    mean_us: float
    worst_us: float
    flash_bytes: int
    ram_bytes: int
    difference_rad: float
    instructions: dict[str, float]


def measure(
    sources: Mapping[str, str], inputs: FloatArray, defines: tuple[str, ...] = ()
) -> tuple[FloatArray, FloatArray, int, int]:
    """Compile a method with the harness and run it in the simulator.

    Parameters
    ----------
    sources : mapping of str to str
        Files with ``bench_start`` and ``bench_step``.
    inputs : ndarray, shape (N, C)
        Signal.
    defines : tuple of str
        Options of the compiler.

    Returns
    -------
    time_us : ndarray, shape (N,)
        Of each sample.
    angle_rad : ndarray, shape (N,)
        First angle.
    flash_bytes, ram_bytes : int
        Without the signal; without the stack.
    """
    bench = (resources.files("narx.experiments.embedded") / "bench.c").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, content in {
            **sources,
            "bench.c": bench,
            "signal.h": signal_header(inputs),
        }.items():
            (folder / file).write_text(content, encoding="utf-8")
        units = [file for file in (*sources, "bench.c") if file.endswith(".c")]
        command = ["avr-gcc", *_FLAGS, *defines, *units, "-o", "bench.elf", "-lm"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        size = subprocess.run(
            ["avr-size", "bench.elf"], cwd=folder, check=True, capture_output=True, text=True
        )
        text, data, bss = map(int, size.stdout.splitlines()[1].split()[:3])
        run = subprocess.run(
            ["simavr", "-m", "atmega328p", "-f", f"{CLOCK_HZ:.0f}", "bench.elf"],
            cwd=folder, check=True, capture_output=True, text=True, timeout=300,
        )  # fmt: skip
    printed = re.sub(r"\x1b\[[0-9;]*m", "", run.stdout + run.stderr)
    found = re.findall(r"(\d+) ([0-9a-f]{8})", printed)
    if len(found) != len(inputs):
        raise UserError(f"simavr: {len(found)} samples came back, expected {len(inputs)}")
    counts = np.array([int(count) for count, _ in found], dtype=float)
    bits = np.array([int(digits, 16) for _, digits in found], dtype=np.uint32)
    flash = text + data - inputs.size * 4
    angle_rad = bits.view(np.float32).astype(float)
    return counts * TIMER_CYCLES / CLOCK_HZ * 1e6, angle_rad, flash, data + bss


def signal_header(inputs: FloatArray) -> str:
    """Write a signal as C.

    Parameters
    ----------
    inputs : ndarray, shape (N, C)
        Signal.

    Returns
    -------
    str
        Content of ``signal.h``.
    """
    lines = (", ".join(f"{value!r}f" for value in row) for row in inputs.tolist())
    rows = ",\n".join(f"{{{line}}}" for line in lines)
    return (
        f"#define SAMPLES {len(inputs)}\n#define COLUMNS {inputs.shape[1]}\n"
        f"static const float SIGNAL[SAMPLES][COLUMNS] PROGMEM = {{\n{rows}\n}};\n"
    )


def _network(checkpoint: Checkpoint) -> dict[str, str]:
    files = c.stamped(c.build(checkpoint, "float"), "narx", "")
    own = (resources.files("narx.experiments.embedded") / "network.c").read_text(encoding="utf-8")
    return {**files, "network.c": own}


def _axis_by_axis(checkpoint: Checkpoint) -> Checkpoint:
    """The same network without the conversion of rates, as the papers have it."""
    model = checkpoint.model
    apart = Narx(model.sampling_rate_hz, model.normalisation, model.structure, coupled=False)
    with torch.no_grad():
        apart.weights.copy_(model.weights)
    return replace(checkpoint, model=apart)


def _rivals(two_point: TwoPointParts) -> dict[str, str]:
    start, stop = two_point.start, two_point.stop
    assert start is not None
    assert stop is not None
    drift = two_point.drift_rad[:, 0]
    slope = (drift[stop] - drift[start]) / (stop - start)
    dt = 1.0 / RATE_HZ
    leak = 0.5 * dt * _PSEUDO_HZ
    constants = {
        "PI": np.pi,
        "INTERVAL_S": dt,
        "HALF_INTERVAL_S": 0.5 * dt,
        "GAIN": 1.0 - _ALPHA,
        "THRESHOLD_RAD_S": np.radians(_REST_DEG_S),
        "LOW": (GRAVITY_M_S2 - _ETA_M_S2) ** 2,
        "HIGH": (GRAVITY_M_S2 + _ETA_M_S2) ** 2,
        "KEPT": (1.0 - leak) / (1.0 + leak),
        "TURN": 0.5 * dt / (1.0 + leak),
        "LEAK": leak / (1.0 + leak),
        "SLOPE": slope,
        "LINE": drift[start] - slope * start,
    }
    lines = [f"#define {name} {float(value)!r}f" for name, value in constants.items()]
    code = (resources.files("narx.experiments.embedded") / "rivals.c").read_text(encoding="utf-8")
    return {"rivals.c": code, "constants.h": "\n".join(lines) + "\n"}


def costs() -> dict[str, Cost]:
    """Measure all methods on a walk that begins with standing.

    Returns
    -------
    dict of str to Cost
        By method.
    """
    shipped = pretrained()
    methods: dict[str, tuple[OrientationMethod, dict[str, str], tuple[str, ...]]] = {}
    sagittal = ["sagittal"]
    walk = verification.walk(np.arange(round(_SECONDS * RATE_HZ)) / RATE_HZ)
    # in the digits that the processor has
    walk = walk.astype(np.float32).astype(float)
    signals = SegmentSignals("thigh", RATE_HZ, walk[:, :3], walk[:, 3:])
    two_point = TwoPoint(*_STANDS_S)
    rivals: dict[str, OrientationMethod] = {
        "complementary filter": ComplementaryFilter.from_alpha(_ALPHA, RATE_HZ, axes=sagittal),
        "GIOF": Giof("real_time", sagittal, _ETA_M_S2, _REST_DEG_S, rest_s=0.0, low_pass_hz=None),
        "pseudo-integrator": PseudoIntegrator(gait_frequency_hz=_PSEUDO_HZ),
        "2-point": two_point,
    }
    for number, (name, rival) in enumerate(rivals.items(), start=1):
        methods[name] = rival, _rivals(two_point.parts(signals)), (f"-DMETHOD={number}",)
    # a start-up that is over before the walk is
    start_up = StartUp(duration_s=1.0, averaging_s=0.5, averaging_begin_s=0.0)
    plain = replace(shipped, tracker=None, start_up=start_up)
    single = _axis_by_axis(plain)
    methods["NARX, sagittal"] = single.method(), _network(single), ("-DNARX_AXES=1",)
    methods["NARX, three axes"] = plain.method(), _network(plain), ()
    methods["NARX with tracker"] = shipped.method(), _network(shipped), ()
    walking = slice(len(walk) // 2, None)
    found = {}
    for name, (method, sources, defines) in methods.items():
        columns = 3 if name.startswith("NARX") else 6
        time_us, angle_rad, flash, ram = measure(sources, walk[:, :columns], defines)
        expected_rad = method.estimate(signals)[:, 0]
        if method is two_point:
            expected_rad[np.isnan(two_point.parts(signals).drift_rad[:, 0])] = np.nan
        differences, instructions = [angle_rad - expected_rad], {}
        for processor in [] if programs.missing(programs.CORTEX) else cortex.PROCESSORS:
            files = {**sources, "signal.h": signal_header(walk[:, :columns])}
            counts, angle_rad = cortex.count(files, processor, defines)
            instructions[processor] = float(counts[walking].mean())
            differences.append(angle_rad - expected_rad)
        # the 2-point method's program gives the samples between its points
        difference_rad = float(np.nanmax(np.abs(differences)))
        mean_us, worst_us = float(time_us[walking].mean()), float(time_us[walking].max())
        found[name] = Cost(mean_us, worst_us, flash, ram, difference_rad, instructions)
    return found


def table(measured: Mapping[str, Cost]) -> str:
    """Lay the costs out in Markdown.

    Parameters
    ----------
    measured : mapping of str to Cost
        From `costs`.

    Returns
    -------
    str
        As docs/export.md has it.
    """
    lines = [
        "| method | mean, us | worst, us | paper, us | flash, bytes | RAM, bytes | error, rad | "
        + " | ".join(f"{name}, instructions" for name in cortex.PROCESSORS)
        + " |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, cost in measured.items():
        lines.append(
            f"| {name} | {cost.mean_us:.0f} | {cost.worst_us:.0f} | {PAPERS_US.get(name, '')} | "
            f"{cost.flash_bytes} | {cost.ram_bytes} | {cost.difference_rad:.0e} | "
            + " | ".join(f"{cost.instructions.get(p, np.nan):.0f}" for p in cortex.PROCESSORS)
            + " |"
        )
    return "\n".join(lines)


def main() -> None:
    """Print the table, or what is missing for it."""
    imported()
    parser = argparse.ArgumentParser(
        "python -m experiments.embedded",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.parse_args()
    missing = programs.missing(programs.AVR)
    if missing:
        print(f"embedded: skipped, not installed: {', '.join(missing)} (gcc-avr avr-libc simavr)")
        return
    print(table(costs()))


if __name__ == "__main__":
    main()
