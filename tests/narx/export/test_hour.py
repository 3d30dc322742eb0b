"""Exports in float stay with the package over minutes, and over an hour."""

import importlib.util
import shutil
from pathlib import Path

import numpy as np
import pytest

SCRIPT = Path(__file__).resolve().parents[3] / "docs" / "export_hour.py"
SECONDS = 1.0 / 60.0


@pytest.fixture(scope="module")
def hour():
    spec = importlib.util.spec_from_file_location("export_hour", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("export_format", "minutes"),
    [
        ("c", 5.0),
        ("torchscript", 20.0 * SECONDS),
        pytest.param("c", 60.0, marks=pytest.mark.slow),
        pytest.param("torchscript", 5.0, marks=pytest.mark.slow),
        pytest.param("onnx", 5.0, marks=pytest.mark.slow),
        pytest.param("torch_export", 1.0, marks=pytest.mark.slow),
    ],
)
def test_float_stays_with_the_package(hour, export_format, minutes):
    if export_format == "c" and shutil.which("gcc") is None:
        pytest.skip("no gcc")
    if export_format == "onnx":
        for library in ("onnx", "onnxscript", "onnxruntime"):
            pytest.importorskip(library)
    regular = hour.walk(minutes, 5, packets=False)
    packets = hour.walk(minutes, 6, packets=True)
    assert np.ptp(regular[1]) == 0.0
    assert np.ptp(packets[1]) > 0.09
    rates, interval_s = (np.stack(part) for part in zip(regular, packets, strict=True))
    assert 0.01 < np.isnan(rates).any(axis=2).mean() < 0.03
    of_samples, of_packets = hour.differences(export_format, "float", rates, interval_s)
    assert of_samples.max() < 1e-4
    # its frontal angle drifts to 50 degrees, where a difference in the tilt turns the heading
    assert of_packets[:2].max() < 1e-4
    assert of_packets[2] < 2e-4


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_another_pattern_of_missing_angles_is_an_error(hour, monkeypatch):
    rates, interval_s = (part[None] for part in hour.walk(SECONDS, 5, packets=False))
    monkeypatch.setattr(hour, "runner", lambda *_: lambda rates, *_: np.zeros_like(rates))
    rates[0, 3] = np.nan
    with pytest.raises(SystemExit, match="c, float: other samples are missing"):
        hour.differences("c", "float", rates, interval_s)
