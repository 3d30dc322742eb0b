"""A checkpoint with a changed field is refused in one line, or is a network that runs."""

import os

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.inference import checkpoint as checkpoints
from narx.inference.checkpoint_archive import digest, to_bytes
from narx.inference.pretrained import pretrained
from narx.inference.stream import OrientationStream

VALUES = (
    None, True, False, 0, -1, 3, 10**30, 0.0, -0.5, 1e-300, 1e300, np.inf, -np.inf, np.nan, "", "x",
    "100", [], [1.0], [1.0, 2.0, 3.0], [None] * 3, {}, {"a": 1},
)  # fmt: skip


def places(content, path=()):
    """Paths to all fields, also within dictionaries."""
    for name, value in content.items():
        yield (*path, name)
        if isinstance(value, dict) and name != "history":
            yield from places(value, (*path, name))


def changed(content, rng):
    """Replace, remove, rename or add one field; return the place."""
    content = torch.load(content, weights_only=True)
    del content["sha256"]
    every = list(places(content))
    path = every[rng.integers(len(every))]
    within = content
    for name in path[:-1]:
        within = within[name]
    kind = rng.integers(6)
    if kind == 0:
        del within[path[-1]]
    elif kind == 1:
        within[f"{path[-1]}_"] = within.pop(path[-1])
    elif kind == 2:
        within["another"] = VALUES[rng.integers(len(VALUES))]
    else:
        within[path[-1]] = VALUES[rng.integers(len(VALUES))]
    return content, path


@pytest.mark.slow
@pytest.mark.parametrize("sealed", [True, False], ids=["sealed", "unsealed"])
def test_changed_fields(tmp_path, sealed):
    """NARX_FUZZ_CASES=1000 is the long run."""
    good, bad = tmp_path / "good.pt", tmp_path / "bad.pt"
    checkpoints.save(pretrained(), good)
    whole, rng = torch.load(good, weights_only=True), np.random.default_rng(int(sealed))
    samples = np.random.default_rng(2).normal(size=(20, 6))
    cases, messages = int(os.environ.get("NARX_FUZZ_CASES", "100")), []
    for _ in range(cases):
        content, path = changed(good, rng)
        content["sha256"] = digest(content) if sealed else whole["sha256"]
        bad.write_bytes(to_bytes(content))
        try:
            again = checkpoints.load(bad)
        except UserError as error:
            messages.append(str(error))
            continue
        if not sealed:
            assert again.sha256 == pretrained().sha256, path
            continue
        stream = OrientationStream(again.method(), again.model.sampling_rate_hz)
        assert stream.update_block(samples).angles_rad.shape == (20, 3), path
    assert len(messages) > cases / 2
    assert not [message for message in messages if "\n" in message]
