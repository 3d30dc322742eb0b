"""Architecture: layered imports, no code used by tests alone, cheap imports."""

import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

# a package may import from itself and from lower layers; packages of one layer are independent
FLOORS = (
    ("errors", "files", "types"),
    ("kernels", "missing", "settings"),
    ("kinematics", "recursion"),
    ("recordings", "method", "network"),
    ("simulation", "gait", "calibration", "windows"),
    ("datasets", "inference"),
    ("baselines",),
    ("training", "export"),
    ("evaluation",),
    ("experiments",),
)
FLOOR_OF = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}


def _dotted(path: Path) -> str:
    parts = list(path.relative_to(ROOT).with_suffix("").parts)
    if parts[0] != "narx":
        parts.insert(0, "narx")
    return ".".join(parts).removesuffix(".__init__")


MODULES = {
    _dotted(path): path
    for folder in ("narx", "baselines", "experiments")
    for path in sorted((ROOT / folder).rglob("*.py"))
    if not any(parent.is_symlink() for parent in path.parents if parent != ROOT)
}


def room_of(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


@cache
def imports_of(module: str) -> frozenset[str]:
    return frozenset(_imported(ast.parse(MODULES[module].read_text())) & set(MODULES) - {module})


def _imported(tree: ast.AST) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            found.add(node.module)
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def test_every_module_has_a_room():
    assert {room_of(module) for module in MODULES if module != "narx"} <= set(FLOOR_OF)


@pytest.mark.parametrize("module", [module for module in MODULES if module != "narx"])
def test_imports_run_downwards(module):
    room = room_of(module)
    others = {room_of(name) for name in imports_of(module) if name != "narx"} - {room, ""}
    upwards = {other for other in others if FLOOR_OF[other] >= FLOOR_OF[room]}
    assert not upwards, f"{module} imports from {', '.join(sorted(upwards))}"


def test_no_import_goes_in_circles():
    done: set[str] = set()

    def visit(module: str, path: tuple[str, ...]) -> None:
        assert module not in path, " -> ".join([*path, module])
        if module not in done:
            for name in imports_of(module):
                visit(name, (*path, module))
            done.add(module)

    for module in MODULES:
        if module != "narx":
            visit(module, ())


def test_no_module_is_used_only_by_tests():
    """Every module is imported by another one, is named in a configuration, or is a command."""
    used: set[str] = set()
    for module in MODULES:
        used |= imports_of(module)
    configured = "\n".join(path.read_text() for path in (ROOT / "configs").rglob("*.yaml"))
    project = (ROOT / "pyproject.toml").read_text()
    named = set(re.findall(r"narx(?:\.\w+)+", configured + project))
    alone = {
        module
        for module in MODULES
        if module not in used
        and MODULES[module].name != "__init__.py"
        and not any(name == module or name.startswith(f"{module}.") for name in named)
        and not module.endswith("__main__")
        and 'if __name__ == "__main__"' not in MODULES[module].read_text()
    }
    assert not alone


def test_array_types_are_defined_once():
    pattern = re.compile(r"NDArray\[np\.(float64|bool_)\]")
    elsewhere = [m for m, path in MODULES.items() if pattern.search(path.read_text())]
    assert elsewhere == ["narx.types"]


def test_the_top_of_the_package_stays_small():
    assert len(list((ROOT / "narx").glob("*.py"))) <= 12


def test_importing_the_package_pulls_in_nothing_heavy():
    script = "import sys, narx; print(*{'torch', 'numba', 'scipy'} & set(sys.modules))"
    answer = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert answer.stdout.strip() == ""


def test_every_public_name_can_be_imported():
    script = (
        "import narx\n"
        "for name in narx.__all__:\n"
        "    assert getattr(narx, name) is not None\n"
        "assert set(narx.__all__) <= set(dir(narx))\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, cwd=ROOT)


@pytest.mark.parametrize("module", MODULES)
def test_files_stay_small(module):
    assert len(MODULES[module].read_text().splitlines()) <= 400
