import json

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.export import torch_export


@pytest.mark.parametrize("checkpoint", ["longer_delays"], indirect=True)
def test_loaded_program_equals_the_package(checkpoint, rates, expected, tmp_path):
    torch_export.write(checkpoint, tmp_path / "narx.pt2")
    extra = {"narx.json": ""}
    step = torch.export.load(tmp_path / "narx.pt2", extra_files=extra).module()
    about = json.loads(extra["narx.json"])
    assert about["sampling_rate_hz"] == 25.0
    for start, angles in expected.values():
        state = torch.tensor(about["start_state"], dtype=torch.float64)
        if start is not None:
            # as `known_start` says
            state[0:3] = torch.from_numpy(start)
            state[13] = 1.0
        result = np.empty_like(rates)
        for k, sample in enumerate(torch.from_numpy(rates)):
            one, state = step(sample, state)
            result[k] = one.numpy()
        np.testing.assert_allclose(result, angles, atol=1e-8, rtol=0)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_another_suffix_is_refused(checkpoint, tmp_path):
    with pytest.raises(UserError, match=r"narx\.pt', expected a name that ends in \.pt2"):
        torch_export.write(checkpoint, tmp_path / "narx.pt")
    assert not list(tmp_path.iterdir())
