import io
import subprocess
import sys

import numpy as np
import pytest
import torch

from narx.export import torchscript, write

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


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_unusual_inputs_are_right_or_refused(checkpoint, rates, expected):
    narx = torch.jit.load(io.BytesIO(torchscript.build(checkpoint, torch.float64)))
    samples = torch.from_numpy(rates[:60])
    angles = narx(samples)
    np.testing.assert_allclose(angles, expected["unknown"][1][:60], atol=1e-9, rtol=0)
    assert narx(samples[:0]).shape == (0, 3)
    assert narx(samples.expand(0, 60, 3)).shape == (0, 60, 3)
    across = samples.t().contiguous().t()
    np.testing.assert_array_equal(narx(across), angles)
    np.testing.assert_array_equal(narx(samples.half()), narx(samples.half().double()))
    for interval_s in (0.0, -1.0, np.nan):
        assert narx(samples, None, torch.full((60,), interval_s)).isnan().all()
    assert narx(samples[22:], None, torch.full((38,), np.inf)).isfinite().all()
    for arguments, reason in (
        ((samples[0],), r"the shape \[3\], expected \(\.\.\., N, 3\)"),
        ((samples[:, :2],), r"the shape \[60, 2\], expected"),
        ((samples, None, torch.ones(59)), r"interval_s has the shape \[59\], expected \[60\]"),
        ((samples, torch.full((3,), np.nan)), "expected three finite angles"),
        ((samples, torch.full((3,), 1e300, dtype=torch.float64)), "expected three finite angles"),
        ((samples, torch.zeros(2)), "expected three finite angles"),
    ):
        with pytest.raises(Exception, match=reason):
            narx(*arguments)
    with pytest.raises(Exception, match="inputs have 3 columns and the state 5, expected 3 and"):
        narx.step(samples[0], torch.zeros(5))
