import importlib.util
import json

import numpy as np
import pytest

from narx.errors import UserError
from narx.export import onnx


@pytest.mark.parametrize("checkpoint", ["default"], indirect=True)
def test_a_missing_library_is_one_line(checkpoint, tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"^format=onnx needs onnx and onnxscript.*pip install"):
        onnx.write(checkpoint, tmp_path / "narx.onnx")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("checkpoint", ["default", "offsets"], indirect=True)
def test_onnxruntime_equals_the_package(checkpoint, rates, initial_angles, expected, tmp_path):
    pytest.importorskip("onnx")
    pytest.importorskip("onnxscript")
    runtime = pytest.importorskip("onnxruntime")
    onnx.write(checkpoint, tmp_path / "narx.onnx")
    assert [path.name for path in tmp_path.iterdir()] == ["narx.onnx"]
    session = runtime.InferenceSession(tmp_path / "narx.onnx", providers=["CPUExecutionProvider"])
    about = json.loads(session.get_modelmeta().custom_metadata_map["narx"])
    assert about["sampling_rate_hz"] == 50.0
    state = np.array(about["start_state"])
    if initial_angles is not None:
        state[0:3], state[14] = initial_angles, 1.0
    angles = np.empty_like(rates)
    for k, sample in enumerate(rates):
        angles[k], state = session.run(None, {"axis_rates": sample, "state": state})
    np.testing.assert_allclose(angles, expected, atol=1e-8, rtol=0)
