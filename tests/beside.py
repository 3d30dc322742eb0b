"""Import of a file of the tests, for what several tests make."""

import importlib.util
from pathlib import Path
from types import ModuleType


def beside(path: str) -> ModuleType:
    """Import a file of the tests.

    Parameters
    ----------
    path : str
        Below ``tests/``.

    Returns
    -------
    module
        The file.
    """
    file = Path(__file__).parent / path
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
