import subprocess
import sys

import numpy as np
import pytest

from narx.export import write

# what a stranger does with the file; the package cannot be imported there
STRANGER = """
import sys
sys.modules["narx"] = None
import json
import numpy as np
import torch

about = {"narx.json": ""}
narx = torch.jit.load("narx.pt", _extra_files=about)
assert json.loads(about["narx.json"])["sampling_rate_hz"] == narx.sampling_rate_hz == 25.0
rates = torch.from_numpy(np.load("rates.npy"))
results = []
for start in (None, torch.from_numpy(np.load("start.npy"))):
    state = narx.start(start)
    assert state.shape == (narx.state_size,)
    samples = []
    for sample in rates:
        angles, state = narx.step(sample, state)
        samples.append(angles)
    results.append(torch.stack([narx(rates, start), torch.stack(samples)]))
assert not [name for name in sys.modules if name.split(".")[0] in ("narx", "experiments") and
            sys.modules[name]]
np.save("angles.npy", torch.stack(results).numpy())
"""


@pytest.mark.parametrize("checkpoint", ["default", "shortest_delays"], indirect=True)
def test_a_process_with_only_torch_gives_the_same_angles(checkpoint, rates, expected, tmp_path):
    write(checkpoint, tmp_path / "narx.pt", "torchscript")
    np.save(tmp_path / "rates.npy", rates)
    np.save(tmp_path / "start.npy", expected["known"][0])
    arguments = [sys.executable, "-I", "-W", "ignore", "-c", STRANGER]
    subprocess.run(arguments, cwd=tmp_path, check=True)
    results = np.load(tmp_path / "angles.npy")
    for name, (whole, samples) in zip(("unknown", "known"), results, strict=True):
        np.testing.assert_allclose(whole, expected[name][1], atol=1e-9, rtol=0)
        np.testing.assert_array_equal(samples, whole)
