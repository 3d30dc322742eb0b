"""Functions that only kernels call have no entry from Python: a call from there would crash."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
KERNELS = ROOT / "narx" / "kernels"


def test_no_other_module_calls_an_inner_function():
    inner = {
        (path.stem, name)
        for path in KERNELS.glob("*.py")
        for name in re.findall(
            r"@compiled\(\*\*(?:EXACT_)?(?:INNER|VIEWS)\)\ndef (\w+)\(",
            path.read_text(encoding="utf-8"),
        )
    }
    assert ("kalman", "measure_state") in inner
    used = set()
    for folder in ("narx", "baselines", "experiments"):
        for path in (ROOT / folder).rglob("*.py"):
            if path.parent != KERNELS:
                used |= _used(ast.parse(path.read_text(encoding="utf-8")))
    assert ("clock", "longest_pause") in used
    assert not inner & used


def _used(tree):
    """Names of functions of kernels that a module imports or reads, with their files."""
    aliases, used = {}, set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("narx.kernels"):
            for name in node.names:
                used.add((node.module.rpartition(".")[2], name.name))
                if node.module == "narx.kernels":
                    aliases[name.asname or name.name] = name.name
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            used.add((aliases.get(node.value.id), node.attr))
    return used
