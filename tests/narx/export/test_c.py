import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from narx.errors import UserError
from narx.export import c

needs_compiler = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
FLAGS = (
    "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror",
)  # fmt: skip


def compiled(checkpoint, folder, precision):
    c.write(checkpoint, folder / "narx.c", precision)
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


@needs_compiler
@pytest.mark.parametrize(
    ("precision", "dtype", "atol_rad"),
    [("double", np.float64, 1e-8), ("float", np.float32, 1e-5)],
)
def test_compiled_equals_the_package(
    checkpoint, rates, expected, tmp_path, precision, dtype, atol_rad
):
    library = compiled(checkpoint, tmp_path, precision)
    for start, angles in expected.values():
        result = run(library, rates, start, dtype)
        np.testing.assert_allclose(result, angles, atol=atol_rad, rtol=0)


@needs_compiler
@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_header_serves_c_plus_plus(checkpoint, tmp_path):
    c.write(checkpoint, tmp_path / "narx.c")
    (tmp_path / "main.cpp").write_text(
        '#include "narx.h"\n'
        "int main() { narx_state state; narx_start(&state, nullptr);\n"
        "narx_real rates[3] = {0, 0, 0}, angles[3]; narx_step(&state, rates, angles);\n"
        "return angles[0] == angles[0] ? 0 : 1; }\n"
    )
    subprocess.run(["gcc", *FLAGS, "-c", "narx.c"], cwd=tmp_path, check=True)
    subprocess.run(["gcc", "-c", "main.cpp"], cwd=tmp_path, check=True)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_names_and_precision_are_checked(checkpoint, tmp_path):
    with pytest.raises(UserError, match=r"narx\.txt', expected a name that ends in \.c"):
        c.write(checkpoint, tmp_path / "narx.txt")
    with pytest.raises(UserError, match="precision is 'half', expected one of double, float"):
        c.write(checkpoint, tmp_path / "narx.c", "half")
    assert not list(tmp_path.iterdir())
