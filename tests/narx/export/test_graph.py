"""The sequence graph gives the same angles in pieces of any size, for any number of sensors."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import torch

from narx.export import write
from narx.inference.stream import OrientationStream

pytestmark = pytest.mark.slow


def torch_export_file(path, dtype):
    about = {"narx.json": ""}
    module = torch.export.load(path, extra_files=about).module()

    def run(rates, intervals, state):
        outputs = module(*(torch.from_numpy(part) for part in (rates, intervals, state)))
        return [output.numpy() for output in outputs]

    return run, json.loads(about["narx.json"])


def onnx_file(path, dtype):
    runtime = pytest.importorskip("onnxruntime")
    options = runtime.SessionOptions()
    options.log_severity_level = 3
    session = runtime.InferenceSession(path, options, providers=["CPUExecutionProvider"])

    def run(rates, intervals, state):
        feed = {"axis_rates": rates, "interval_s": intervals, "state": state}
        return session.run(["angles", "new_state", "std_rad", "quality"], feed)

    return run, json.loads(session.get_modelmeta().custom_metadata_map["narx"])


@pytest.mark.parametrize(
    ("checkpoint", "name", "suffix", "load", "precision", "dtype", "atol_rad"),
    [
        ("default", "torch_export", "pt2", torch_export_file, "float", np.float32, 1e-4),
        ("longer_delays", "onnx", "onnx", onnx_file, "double", np.float64, 1e-9),
    ],
    indirect=["checkpoint"],
)
def test_pieces_of_several_sensors_equal_the_package(
    checkpoint, name, suffix, load, precision, dtype, atol_rad, rates, tmp_path
):
    if name == "onnx":
        pytest.importorskip("onnxscript")
    checkpoint = replace(
        checkpoint, error_std_rad=(0.01, 0.02, 0.03), start_std_rad=(0.1, 0.2, 0.3)
    )
    path = tmp_path / f"narx.{suffix}"
    write(checkpoint, path, name, precision)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
    run, about = load(path, dtype)
    several = np.stack([rates, rates[::-1], np.roll(rates, 30, axis=0)]).astype(dtype)
    starts = np.array([[0.3, -0.1, 0.2], [0.0, 0.0, 0.0], [-0.2, 0.1, 0.0]], dtype)
    intervals = np.full(several.shape[:2], 0.04, dtype)
    known = about["known_start"]
    state = np.tile(np.array(known["state"], dtype), (3, 1))
    for axis, at in enumerate(known["angles_at"]):
        state[:, at] = starts[:, axis, None]
    stream = OrientationStream(checkpoint.method(), 25.0, n_sensors=3, initial_angles_rad=starts)
    for piece, passed in zip(
        np.split(several, [1, 2, 20, 100], axis=1),
        np.split(intervals, [1, 2, 20, 100], axis=1),
        strict=True,
    ):
        angles, state, std_rad, quality = run(
            np.ascontiguousarray(piece), np.ascontiguousarray(passed), state
        )
        expected = stream.update_block(piece)
        np.testing.assert_allclose(angles, expected.angles_rad, atol=atol_rad, rtol=0)
        np.testing.assert_array_equal(quality, expected.quality)
        np.testing.assert_allclose(std_rad, expected.std_rad, rtol=1e-6)
    angles, *_ = run(several[:0, :20].copy(), intervals[:0, :20].copy(), state[:0])
    assert angles.shape == (0, 20, 3)
    # runtimes refuse a scan over nothing
    with pytest.raises(Exception, match=r"out of range|Invalid dim0_offset"):
        run(several[:, :0].copy(), intervals[:, :0].copy(), state)


STRANGER = """
import sys
sys.modules["narx"] = None
import json
import numpy as np
import torch

about = {"narx.json": ""}
graph = torch.export.load("narx.pt2", extra_files=about).module()
state = torch.tensor([json.loads(about["narx.json"])["start_state"]], dtype=torch.float64)
rates, ends = torch.from_numpy(np.load("rates.npy"))[None], np.load("ends.npy")
parts = []
for begin, end in zip(ends[:-1], ends[1:]):
    intervals = torch.full((1, end - begin), 0.04, dtype=torch.float64)
    angles, state, std_rad, quality = graph(rates[:, begin:end].contiguous(), intervals, state)
    parts.append(angles[0].numpy())
np.save("angles.npy", np.concatenate(parts))
"""


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_a_process_with_only_torch_runs_the_graph(checkpoint, rates, tmp_path):
    """In blocks of random size, with 2 % of the samples lost."""
    write(checkpoint, tmp_path / "narx.pt2", "torch_export")
    generator = np.random.default_rng(3)
    lossy = rates.copy()
    lossy[generator.random(len(rates)) < 0.02] = np.nan
    inner = generator.choice(np.arange(1, len(rates)), 12, replace=False)
    np.save(tmp_path / "ends.npy", np.r_[0, np.sort(inner), len(rates)])
    np.save(tmp_path / "rates.npy", lossy)
    arguments = [sys.executable, "-I", "-W", "ignore", "-c", STRANGER]
    subprocess.run(arguments, cwd=tmp_path, check=True)
    expected = OrientationStream(checkpoint.method(), 25.0).update_block(lossy).angles_rad
    np.testing.assert_allclose(np.load(tmp_path / "angles.npy"), expected, atol=1e-9, rtol=0)
