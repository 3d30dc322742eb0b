"""Exports in float stay with the package over minutes and, marked slow, over an hour."""

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
    walks = [hour.walk(minutes, seed, lost) for seed, lost in enumerate(hour.LOSSES)]
    rates, interval_s = (np.stack(part) for part in zip(*walks, strict=True))
    assert 0.01 < np.isnan(rates).any(axis=2).mean() < 0.03
    np.testing.assert_allclose(interval_s[0], 0.01, rtol=1e-6)
    assert interval_s[1].max() > 0.1
    np.testing.assert_allclose(interval_s[1] * 100.0, np.round(interval_s[1] * 100.0), rtol=1e-6)
    assert 0.0011 < interval_s[2, interval_s[2] < 0.015].std() < 0.0014
    assert hour.differences(export_format, "float", rates, interval_s).max() < 1e-4


def test_lost_packets_are_missing_and_the_walk_goes_on(hour):
    sent, _ = hour.walk(4.0, 1, "samples")
    received, interval_s = hour.walk(4.0, 1, "samples and packets")
    assert 1.03 < interval_s.sum() / (len(interval_s) / 100.0) < 1.08
    at = np.round(np.cumsum(interval_s) * 100.0).astype(int) - 1
    common = at < len(sent)
    np.testing.assert_array_equal(received[common], sent[at[common]])


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_another_pattern_of_missing_angles_is_an_error(hour, monkeypatch):
    rates, interval_s = (part[None] for part in hour.walk(SECONDS, 5, "samples"))
    monkeypatch.setattr(hour, "runner", lambda *_: lambda rates, *_: np.zeros_like(rates))
    rates[0, 3] = np.nan
    with pytest.raises(SystemExit, match="c, float: other samples are missing"):
        hour.differences("c", "float", rates, interval_s)
