"""What a run reads is part of its identity."""

import hashlib

import pytest
from omegaconf import OmegaConf

from narx.errors import UserError
from narx.experiments.sources import data_sha256, open_sources


def test_a_network_is_identified_by_its_content_not_by_its_path(tmp_path):
    file = tmp_path / "start.pt"
    file.write_bytes(b"first")
    cfg = OmegaConf.create({"checkpoint": None, "training": {"start": str(file)}})
    assert data_sha256(cfg) == {"training.start": hashlib.sha256(b"first").hexdigest()}
    file.write_bytes(b"second")
    assert data_sha256(cfg) == {"training.start": hashlib.sha256(b"second").hexdigest()}


def test_a_network_that_is_missing_is_left_to_the_command(tmp_path):
    cfg = OmegaConf.create({"checkpoint": str(tmp_path / "missing.pt")})
    assert data_sha256(cfg) == {}


@pytest.mark.parametrize("inside", ["", "inside"])
def test_a_store_that_cannot_be_written_is_named(tmp_path, inside):
    (tmp_path / "file").write_text("a file")
    source = {"_target_": "narx.datasets.simulated_gait.SimulatedGait"}
    folder = str(tmp_path / "file" / inside)
    cfg = OmegaConf.create(
        {"data": {"simulated_gait": source}, "data_root": None,
         "prepared": {"folder": folder, "limit_gb": 1}}
    )  # fmt: skip
    with pytest.raises(UserError, match=r"^prepared\.folder: .*file.* cannot be written"):
        open_sources(cfg)
