"""The examples in the documentation run, and the site builds without warnings."""

import importlib.util
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from narx.datasets import SimulatedGait
from narx.export import write
from narx.inference import pretrained
from narx.method import SegmentSignals

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    "README.md",
    "CONTRIBUTING.md",
    *(str(p.relative_to(ROOT)) for p in sorted((ROOT / "docs").rglob("*.md"))),
]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
BLOCKS = {page: BLOCK.findall((ROOT / page).read_text()) for page in PAGES}


def walk(n=4000, rate_hz=100.0):
    """Like a leg, faster forward than backward; the second harmonic makes the difference."""
    phase = 1.196 + 2.0 * np.pi * 0.9 * np.arange(n - 300) / rate_hz  # begins at rest
    rates = np.zeros((n, 3))
    rates[300:, 0] = 1.6 * (np.cos(phase) + 0.5 * np.cos(2.0 * phase))
    return rates


def gyroscope():
    """The same walk from a sensor whose x points forward and y to the left: flexion about -y."""
    return walk()[:, [1, 0, 2]] * [1.0, -1.0, 1.0]


def exported(folder):
    # the page shows the graphs of a network without a tracker
    checkpoint = replace(pretrained(), tracker=None)
    for name, export_format in (
        ("narx.pt", "torchscript"), ("narx.pt2", "torch_export"), ("narx.onnx", "onnx"),
    ):  # fmt: skip
        write(checkpoint, folder / name, export_format, verify=False)
    return {"axis_rates": torch.from_numpy(walk(50)), "pose": [0.1, 0.0, 0.2]}


# what a page takes as given: the reader's own arrays and files
GIVEN = {
    "README.md": lambda folder: {"gyroscope_rad_s": gyroscope()},
    "docs/predict.md": lambda folder: {"gyroscope_rad_s": gyroscope()},
    "docs/model_card.md": lambda folder: {"gyroscope_rad_s": gyroscope()},
    "docs/export.md": exported,
}


def _needs_recordings(page):
    return any('"recordings/' in block for block in BLOCKS[page])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*:DeprecationWarning")
@pytest.mark.parametrize("page", [page for page in PAGES if BLOCKS[page]])
def test_python_blocks_run(page, tmp_path, monkeypatch):
    root = os.environ.get("NARX_DATA_ROOT")
    if _needs_recordings(page):
        if root is None:
            pytest.skip("needs real recordings below NARX_DATA_ROOT")
        (tmp_path / "recordings").symlink_to(root)
    monkeypatch.chdir(tmp_path)
    names = GIVEN.get(page, lambda folder: {})(tmp_path)
    for number, block in enumerate(BLOCKS[page], 1):
        if "onnxruntime" in block:
            pytest.importorskip("onnxruntime")
            names["axis_rates"], names["interval_s"] = walk(50)[None], np.full((1, 50), 0.01)
        if "torch.export.load" in block:
            names["axis_rates"] = torch.from_numpy(walk(50)[None])
            names["interval_s"] = torch.full((1, 50), 0.01, dtype=torch.float64)
        exec(compile(block, f"{page}, block {number}", "exec"), names)


def test_first_programs_are_short():
    blocks = BLOCKS["docs/python.md"]
    assert len(blocks) >= 4
    assert max(len(block.splitlines()) for block in blocks) <= 25


def test_examples_of_additions_are_short():
    assert max(len(block.splitlines()) for block in BLOCKS["CONTRIBUTING.md"]) < 50


def test_the_picture_of_the_house_shows_the_rooms():
    house = _load(ROOT / "docs" / "house.py")
    architecture = _load(ROOT / "tests" / "test_architecture.py")
    assert tuple(rooms for rooms, _ in house.FLOORS) == architecture.FLOORS
    drawn = (ROOT / "docs" / "figures" / "house.svg").read_text()
    assert all(f">{room}<" in drawn for room in architecture.FLOOR_OF)


def test_interrupted_walks_sit_down_and_lose_samples():
    interruptions = _load(ROOT / "docs" / "interruptions.py")
    rates = np.random.default_rng(0).normal(size=(2000, 3))
    signals = SegmentSignals("thigh", 100.0, rates, rates, None)
    paused, resumed = interruptions.with_pause(signals, 800, 10.0, 80.0)
    np.testing.assert_array_equal(np.delete(paused.axis_rates_rad_s, range(800, resumed), 0), rates)
    inserted_deg = np.degrees(paused.axis_rates_rad_s[800:resumed, 0].cumsum() / 100.0)
    assert len(inserted_deg) == 1300
    assert inserted_deg[149:1150] == pytest.approx(80.0)
    assert inserted_deg[-1] == pytest.approx(0.0, abs=1e-9)
    lost = np.isnan(interruptions.with_gaps(signals, 0.2, 3, seed=1).axis_rates_rad_s[:, 0])
    assert not lost[:500].any()
    assert 20 <= lost.sum() <= 60


def test_bands_are_shares_of_the_errors_and_of_the_marks():
    bands = _load(ROOT / "docs" / "bands.py")
    rng = np.random.default_rng(0)
    time_s, quality = np.arange(20_000) / 100.0, np.zeros(20_000, dtype=int)
    quality[10_000:] = 4
    walks = [
        bands.Walk(
            subject, "FrontPocket", time_s, sd * np.abs(rng.normal(size=(20_000, 2))), quality
        )
        for subject, sd in (("one", 1.0), ("other", 2.0))
    ]
    np.testing.assert_allclose(bands.scale_of(walks[1].ratio), 2.0, rtol=0.02)
    one, other = bands.scaled(walks)
    # the factor of one person is half that of the other
    np.testing.assert_allclose(np.mean(one.ratio < 1.96, axis=0), 0.99991, atol=2e-4)
    np.testing.assert_allclose(np.mean(other.ratio < 1.96, axis=0), 0.6729, atol=0.01)
    cells = bands.row([other], 0.0, 200.0)
    assert cells["doubtful, %"] == "50 (at most 50)"
    assert cells["start-up or idle, %"] == "0 (at most 0)"
    in_band, or_marked = cells["95 % band"], cells["in the 95 % band or marked"]
    assert in_band in {f"{a} / {b}" for a in (67, 68) for b in (67, 68)}
    assert or_marked in {f"{a} / {b}" for a in (83, 84) for b in (83, 84)}


def test_disturbed_walks_are_scored_where_they_are_disturbed(monkeypatch):
    disturbances = _load(ROOT / "docs" / "disturbances.py")
    assert set(disturbances.SPEEDS) == set(SimulatedGait().conditions)
    monkeypatch.setattr(disturbances, "SPEEDS", ("normal",))
    plain, slipped = (
        disturbances.row(3, options, 30.0, 31.0)
        for options in ({}, {"slips_s": [30.0], "slip_deg": 60.0})
    )
    plain_deg, slipped_deg = (
        max(float(cell) for cell in cells["worst segment"].split(" / "))
        for cells in (plain, slipped)
    )
    assert plain_deg < 4.0
    assert slipped_deg > 1.5 * plain_deg
    assert plain["start-up or idle, %"] == "0"
    for cells in (plain, slipped):
        held, covered = (
            [int(share) for share in cells[name].split(" / ")]
            for name in ("95 % band", "in the 95 % band or marked")
        )
        assert all(0 <= a <= b <= 100 for a, b in zip(held, covered, strict=True))


def _load(path):
    spec = importlib.util.spec_from_file_location(f"loaded_{path.stem}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path):
    pytest.importorskip("mkdocs")
    answer = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-d", tmp_path / "site"],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "calibrate" in (tmp_path / "site" / "api" / "calibration" / "index.html").read_text()
