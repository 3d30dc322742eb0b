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


@needs_compiler
@pytest.mark.parametrize(
    ("precision", "dtype", "atol_rad"),
    [("double", np.float64, 1e-8), ("float", np.float32, 1e-5)],
)
def test_compiled_equals_the_package(checkpoint, rates, expected, in_c, precision, dtype, atol_rad):
    step = in_c(checkpoint, precision, dtype)
    for start, angles in expected.values():
        result = step(rates, start)
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
