import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from narx.export import c, write
from narx.export.neurons import merged_neurons, physical_weights
from narx.inference.stream import OrientationStream

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
FLAGS = (
    "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror",
)  # fmt: skip


def compiled(checkpoint, folder, precision):
    write(checkpoint, folder / "narx.c", "c", precision)
    library = folder / "narx.so"
    subprocess.run(
        ["gcc", *FLAGS, "-O2", "-shared", "-fPIC", "narx.c", "-o", library, "-lm"],
        cwd=folder,
        check=True,
    )
    return ctypes.CDLL(str(library))


def run(library, rates, initial_angles, dtype):
    pointer = np.ctypeslib.ndpointer(dtype, flags="C_CONTIGUOUS")
    library.narx_step.argtypes = [ctypes.c_void_p, pointer, pointer]
    library.narx_start.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    library.narx_step.restype = library.narx_start.restype = None
    state = ctypes.create_string_buffer(4096)
    start = None if initial_angles is None else initial_angles.astype(dtype)
    library.narx_start(state, None if start is None else start.ctypes.data)
    angles = np.empty(rates.shape, dtype)
    for sample, row in zip(rates.astype(dtype), angles, strict=True):
        library.narx_step(state, sample, row)
    return angles


@pytest.mark.parametrize(
    ("precision", "dtype", "atol_rad"),
    [("double", np.float64, 1e-9), ("float", np.float32, 1e-5)],
)
def test_compiled_equals_the_package(
    checkpoint, rates, expected, tmp_path, precision, dtype, atol_rad
):
    library = compiled(checkpoint, tmp_path, precision)
    for start, angles in expected.values():
        result = run(library, rates, start, dtype)
        np.testing.assert_allclose(result, angles, atol=atol_rad, rtol=0)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_time_stamps_equal_the_package(checkpoint, rates):
    rng = np.random.default_rng(0)
    intervals = 0.04 * rng.uniform(0.2, 2.2, (1, len(rates)))
    stream = OrientationStream(checkpoint.method(), 25.0, n_sensors=1)
    expected = stream.update_block(rates[None], np.cumsum(intervals, axis=1)).angles_rad
    files = c.stamped(c.build(checkpoint, "double"), "narx", "")
    np.testing.assert_allclose(c.loaded(files)(rates[None], intervals, None), expected, atol=1e-9)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_nothing_leaves_nan_in_the_state(checkpoint, rates, tmp_path):
    """A run with extreme values among valid samples is finite and free of sanitizer errors."""
    write(checkpoint, tmp_path / "narx.c", "c")
    (tmp_path / "main.c").write_text(
        '#include "narx.h"\n#include <math.h>\n#include <stdio.h>\n'
        "int main(void) {\n"
        "  static const float odd[] = {3e38f, -3e38f, INFINITY, NAN, 0, -1, 1e-30f};\n"
        "  narx_state state; int k; narx_real angles[3];\n"
        "  narx_start(&state, 0);\n"
        "  for (k = 0; k < 2000; k++) {\n"
        "    narx_real rates[3] = {2, -1, 0.5f};\n"
        "    narx_step_after(&state, k % 5 ? 0.04f : odd[k / 5 % 7], rates, angles);\n"
        "    rates[k % 3] = odd[k % 7];\n"
        "    narx_step(&state, rates, angles);\n"
        "  }\n"
        "  { narx_real rates[3] = {2, -1, 0.5f}; narx_step(&state, rates, angles); }\n"
        "  return isfinite(angles[0]) && isfinite(angles[1]) && isfinite(angles[2]) ? 0 : 1;\n}\n"
    )
    flags = ["-std=c99", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    subprocess.run(
        ["gcc", *flags, "narx.c", "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True
    )
    subprocess.run([tmp_path / "main"], check=True)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_header_serves_c_plus_plus(checkpoint, tmp_path):
    if shutil.which("g++") is None:
        pytest.skip("no g++")
    write(checkpoint, tmp_path / "narx.c", "c")
    (tmp_path / "main.cpp").write_text(
        '#include "narx.h"\n'
        "int main() { narx_state state; narx_start(&state, nullptr);\n"
        "narx_real rates[3] = {0, 0, 0}, angles[3]; narx_step(&state, rates, angles);\n"
        "return angles[0] == angles[0] ? 0 : 1; }\n"
    )
    subprocess.run(["gcc", *FLAGS, "-c", "narx.c"], cwd=tmp_path, check=True)
    # linking checks that the object file defines what the header declares
    subprocess.run(["g++", "main.cpp", "narx.o", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    subprocess.run([tmp_path / "main"], check=True)


def test_neurons_that_are_the_same_become_one(checkpoint):
    w1, b1, w2, b2 = physical_weights(checkpoint)
    doubled = np.vstack([w1, w1 * (1 + 1e-4)]), np.tile(b1, 2) * (1 + 1e-4), np.tile(w2 / 2, 2), b2
    merged = merged_neurons(*doubled, 1e-3)
    assert len(merged[2]) == len(w2)
    features = np.random.default_rng(0).normal(size=(50, w1.shape[1]))

    def answer(w1, b1, w2, b2):
        return np.tanh(features @ w1.T + b1) @ w2 + b2

    np.testing.assert_allclose(answer(*merged), answer(*doubled), rtol=0, atol=1e-7)
    for part, whole in zip(merged_neurons(w1, b1, w2, b2, 1e-3), (w1, b1, w2, b2), strict=True):
        np.testing.assert_allclose(part, whole)
