"""The shipped network is valid, and its command reproduces it."""

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate

from narx.experiments.networks import train
from narx.experiments.sources import combined_index, open_sources
from narx.inference.pretrained import pretrained


def test_it_is_stable_and_records_its_provenance():
    checkpoint = pretrained()
    stability = checkpoint.history["stability"]
    assert stability["largest_pole"] < 1.0
    assert stability["contraction_bound"] < 1.0
    assert stability["stable"]
    assert checkpoint.model.odd
    assert checkpoint.model.coupled
    assert all(name.startswith("smartphone_pocket/") for name in checkpoint.history["trained_on"])
    assert "data_root" not in checkpoint.history["config"]


@pytest.mark.recordings
@pytest.mark.slow
def test_its_command_makes_it_again(data_root, request):
    folder = request.config.rootpath / "configs"
    with initialize_config_dir(str(folder), version_base="1.3"):
        cfg = compose(
            "train",
            overrides=[
                "data=smartphone_pocket",
                f"data_root={data_root}",
                "split=everything",
                "optimizer.prior_deg2=10",
            ],
        )
    sources = open_sources(cfg)
    index = combined_index(sources)
    # walkers whose folders came later are not among those it was trained on
    shipped = pretrained()
    kept = index["subject"].isin(["Guillaume", "Thibaud"])
    kept &= index["condition"] == "NoDist_FrontPocket"
    (fold,) = instantiate(cfg.split)(index[kept])
    again = train(cfg, sources, fold, lambda iteration, numbers: None)
    # bit for bit on the machine that trained it; elsewhere up to rounding
    torch.testing.assert_close(
        again.model.weights.detach(), shipped.model.weights.detach(), rtol=1e-6, atol=1e-9
    )
