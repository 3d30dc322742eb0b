"""Time fixed-point arithmetic on an ATmega328P at 8 MHz, and measure its errors.

python docs/fixed_point.py

One product of each kind of number, then a step of the shipped network (three coupled axes, no
tracker, no start-up) with 16-bit factors, fixed_point.c, over a walk. Needs the programs of
`make embedded` and gcc.
"""

import ctypes
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from narx.experiments.embedded.__main__ import RATE_HZ, measure
from narx.export import verification
from narx.export.neurons import merged_neurons, physical_weights
from narx.inference.pretrained import pretrained
from narx.inference.start_up import StartUp
from narx.method import SegmentSignals
from narx.types import FloatArray

TIMES, SECONDS = 20, (6.0, 60.0, 300.0)
PRODUCTS = {
    "float": ("float", "a * b"),
    "16 bits, result shifted by 12": ("int16_t", "(int16_t)(((int32_t)a * b) >> 12)"),
    "32 bits, result shifted by 28": ("int32_t", "(int32_t)(((int64_t)a * b) >> 28)"),
}
PROGRAM = """#include <stdint.h>
void bench_start(void);
void bench_step(const float inputs[3], float angles[3]);
static volatile {kind} a = 12345, b = 23456, result;
void bench_start(void) {{}}
void bench_step(const float inputs[3], float angles[3])
{{
    uint8_t i;
    for (i = 0; i < {times}; i++)
        result = {value};
    angles[0] = inputs[0];
}}
"""


def product_us(kind: str, expression: str) -> float:
    """Time a product without the loads and stores around it, us."""
    signal = np.zeros((20, 3), np.float32)
    times_us = []
    for value in (expression, "a ^ b" if kind != "float" else "a"):
        source = PROGRAM.format(kind=kind, value=value, times=TIMES)
        times_us.append(measure({"product.c": source}, signal)[0][5:].mean() / TIMES)
    return float(times_us[0] - times_us[1])


def constants() -> str:
    """Write the weights in 2^-21 (rates) and 2^-24, of the change from the latest angle."""
    w1, _, w2, _ = merged_neurons(*physical_weights(pretrained()), 1e-3)
    rate, before, latest, earlier = w1[0] * w2[0]
    values = {
        "RATE": rate * 2**21,
        "RATE_BEFORE": before * 2**21,
        "LATEST": (latest - 1.0) * 2**24,
        "BEFORE": earlier * 2**24,
        "CUBE": -(2**24) / (3.0 * w2[0] ** 2),
    }
    return "".join(f"#define {name} {round(value)}\n" for name, value in values.items())


def errors_deg(library: Path, seconds: float) -> FloatArray:
    """Compare the step with the package on a walk: the largest difference (3,), degrees."""
    start_up = StartUp(duration_s=0.0, averaging_s=0.5, averaging_begin_s=0.0)
    method = replace(pretrained(), tracker=None, start_up=start_up).method()
    walk = verification.walk(np.arange(round(seconds * RATE_HZ)) / RATE_HZ)
    inputs = np.ascontiguousarray(walk[:, :3], np.float32)
    expected = method.estimate(SegmentSignals("thigh", RATE_HZ, inputs.astype(float), walk[:, 3:]))
    step, found = ctypes.CDLL(str(library)).bench_step, np.empty_like(inputs)
    for rates, angles in zip(inputs, found, strict=True):
        step(ctypes.c_void_p(rates.ctypes.data), ctypes.c_void_p(angles.ctypes.data))
    return np.asarray(np.degrees(np.abs(found - expected)).max(axis=0))


def main() -> None:
    """Print the times and the differences."""
    for name, (kind, expression) in PRODUCTS.items():
        print(f"a product, {name}: {product_us(kind, expression):.0f} us")
    source = Path(__file__).with_suffix(".c").read_text(encoding="utf-8")
    files = {"fixed_point.c": source, "constants.h": constants()}
    walk = verification.walk(np.arange(600) / RATE_HZ)[:, :3].astype(np.float32)
    print(f"a step with 16-bit factors: {measure(files, walk)[0][300:].mean():.0f} us")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, content in files.items():
            (folder / file).write_text(content, encoding="utf-8")
        for seconds in SECONDS:
            library = folder / f"step_{seconds:g}.so"  # a copy of its state for each walk
            command = ["gcc", "-O2", "-shared", "-fPIC", "fixed_point.c", "-o", library]
            subprocess.run(command, cwd=folder, check=True)
            worst = ", ".join(f"{error:.2f}" for error in errors_deg(library, seconds))
            print(f"largest differences in {seconds:g} s: {worst} degrees")


if __name__ == "__main__":
    main()
