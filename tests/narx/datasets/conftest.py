"""Where real recordings lie, if anywhere."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data_root() -> Path:
    """Folder with a folder per source; skips without it."""
    beside = Path(__file__).parents[4] / "shared" / "data"
    root = Path(os.environ.get("NARX_DATA_ROOT", beside))
    if not root.is_dir():
        pytest.skip("no recordings: set NARX_DATA_ROOT")
    return root
