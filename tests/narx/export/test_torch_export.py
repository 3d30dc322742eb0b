import json

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.export import torch_export


@pytest.mark.parametrize("checkpoint", ["default", "offsets", "longer_delays"], indirect=True)
def test_loaded_program_equals_the_package(checkpoint, rates, initial_angles, expected, tmp_path):
    torch_export.write(checkpoint, tmp_path / "narx.pt2")
    extra = {"narx.json": ""}
    step = torch.export.load(tmp_path / "narx.pt2", extra_files=extra).module()
    about = json.loads(extra["narx.json"])
    assert about["sampling_rate_hz"] == 50.0
    state = torch.tensor(about["start_state"], dtype=torch.float64)
    if initial_angles is not None:
        # as `known_start` says
        state[0:3] = torch.from_numpy(initial_angles)
        state[14] = 1.0
    angles = np.empty_like(rates)
    for k, sample in enumerate(torch.from_numpy(rates)):
        one, state = step(sample, state)
        angles[k] = one.numpy()
    np.testing.assert_allclose(angles, expected, atol=1e-8, rtol=0)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_another_suffix_is_refused(checkpoint, tmp_path):
    with pytest.raises(UserError, match=r"narx\.pt', expected a name that ends in \.pt2"):
        torch_export.write(checkpoint, tmp_path / "narx.pt")
    assert not list(tmp_path.iterdir())
