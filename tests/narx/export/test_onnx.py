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
@pytest.mark.parametrize("checkpoint", ["offsets"], indirect=True)
def test_onnxruntime_equals_the_package(checkpoint, rates, expected, tmp_path):
    pytest.importorskip("onnx")
    pytest.importorskip("onnxscript")
    runtime = pytest.importorskip("onnxruntime")
    onnx.write(checkpoint, tmp_path / "narx.onnx")
    assert [path.name for path in tmp_path.iterdir()] == ["narx.onnx"]
    session = runtime.InferenceSession(tmp_path / "narx.onnx", providers=["CPUExecutionProvider"])
    about = json.loads(session.get_modelmeta().custom_metadata_map["narx"])
    assert about["sampling_rate_hz"] == 25.0
    for start, angles in expected.values():
        state, result = np.array(about["start_state"]), np.empty_like(rates)
        if start is not None:
            state[0:3], state[13] = start, 1.0
        for k, sample in enumerate(rates):
            result[k], state = session.run(None, {"axis_rates": sample, "state": state})
        np.testing.assert_allclose(result, angles, atol=1e-8, rtol=0)
