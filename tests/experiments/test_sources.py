"""What a run reads is part of its identity."""

import hashlib

from omegaconf import OmegaConf

from narx.experiments.sources import data_sha256


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
