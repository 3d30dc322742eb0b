import subprocess
import sys

import numpy as np
import pytest
import torch

from narx.export import torchscript

# what a stranger does with the file; the package cannot be imported there
STRANGER = """
import sys
sys.modules["narx"] = None
import numpy as np
import torch

narx = torch.jit.load("narx.pt")
assert narx.sampling_rate_hz == 25.0
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


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_a_process_with_torch_alone_gets_the_same_angles(checkpoint, rates, expected, tmp_path):
    torchscript.write(checkpoint, tmp_path / "narx.pt")
    np.save(tmp_path / "rates.npy", rates)
    np.save(tmp_path / "start.npy", expected["known"][0])
    arguments = [sys.executable, "-I", "-W", "ignore", "-c", STRANGER]
    subprocess.run(arguments, cwd=tmp_path, check=True)
    results = np.load(tmp_path / "angles.npy")
    for name, (whole, samples) in zip(("unknown", "known"), results, strict=True):
        np.testing.assert_allclose(whole, expected[name][1], atol=1e-8, rtol=0)
        np.testing.assert_array_equal(samples, whole)


def test_loaded_file_equals_the_package(checkpoint, rates, expected, tmp_path):
    torchscript.write(checkpoint, tmp_path / "narx.pt")
    narx = torch.jit.load(tmp_path / "narx.pt")
    for start, angles in expected.values():
        tensor = None if start is None else torch.from_numpy(start)
        result = narx(torch.from_numpy(rates), tensor).numpy()
        np.testing.assert_allclose(result, angles, atol=1e-8, rtol=0)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_nothing_but_the_file_is_left(checkpoint, tmp_path):
    torchscript.write(checkpoint, tmp_path / "narx.pt")
    assert [path.name for path in tmp_path.iterdir()] == ["narx.pt"]
