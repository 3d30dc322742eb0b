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

narx = torch.jit.load(sys.argv[1])
rates = torch.from_numpy(np.load(sys.argv[2]))
start = torch.from_numpy(np.load(sys.argv[3])) if len(sys.argv) > 5 else None
whole = narx(rates, start)
state = narx.start(start)
assert state.shape == (narx.state_size,)
samples = []
for sample in rates:
    angles, state = narx.step(sample, state)
    samples.append(angles)
assert narx.sampling_rate_hz == 50.0
assert not [name for name in sys.modules if name.split(".")[0] in ("narx", "experiments") and
            sys.modules[name]]
np.save(sys.argv[4], torch.stack([whole, torch.stack(samples)]).numpy())
"""


@pytest.mark.parametrize("checkpoint", ["default", "offsets"], indirect=True)
def test_a_process_with_torch_alone_gets_the_same_angles(
    checkpoint, rates, initial_angles, expected, tmp_path
):
    torchscript.write(checkpoint, tmp_path / "narx.pt")
    np.save(tmp_path / "rates.npy", rates)
    arguments = ["narx.pt", "rates.npy", "start.npy", "angles.npy"]
    if initial_angles is not None:
        np.save(tmp_path / "start.npy", initial_angles)
        arguments.append("known")
    subprocess.run(
        [sys.executable, "-I", "-W", "ignore", "-c", STRANGER, *arguments],
        cwd=tmp_path,
        check=True,
    )
    whole, samples = np.load(tmp_path / "angles.npy")
    np.testing.assert_allclose(whole, expected, atol=1e-8, rtol=0)
    np.testing.assert_array_equal(samples, whole)


def test_loaded_file_equals_the_package(checkpoint, rates, initial_angles, expected, tmp_path):
    torchscript.write(checkpoint, tmp_path / "narx.pt")
    narx = torch.jit.load(tmp_path / "narx.pt")
    start = None if initial_angles is None else torch.from_numpy(initial_angles)
    angles = narx(torch.from_numpy(rates), start).numpy()
    np.testing.assert_allclose(angles, expected, atol=1e-8, rtol=0)


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_nothing_but_the_file_is_left(checkpoint, tmp_path):
    torchscript.write(checkpoint, tmp_path / "narx.pt")
    assert [path.name for path in tmp_path.iterdir()] == ["narx.pt"]
