"""Nested selection of settings uses the training trials only."""

import pytest
from omegaconf import OmegaConf

from narx.datasets.splits import Fold, TrialPart
from narx.errors import UserError
from narx.experiments import networks
from narx.inference.checkpoint import Checkpoint
from narx.network.model import Narx
from narx.network.normalisation import Normalisation


def part(subject):
    return TrialPart("walks", subject, "normal", "1")


def test_the_candidate_that_does_best_on_trials_left_out_is_chosen(monkeypatch):
    seen = []

    def train(cfg, sources, fold, log, progress_folder):
        seen.append((cfg.model.hidden, {p.subject for p in (*fold.training, *fold.validation)}))
        assert not set(fold.training) & set(fold.validation)
        error = {1: 2.0, 3: 1.0, 6: 1.5}[cfg.model.hidden]
        report = {"restarts": {"validation_rmse_best_deg": error}}
        return Checkpoint(Narx(100.0, Normalisation(1.0, 1.0)), history={"report": report})

    monkeypatch.setattr(networks, "train", train)
    cfg = OmegaConf.create(
        {
            "seed": 0,
            "model": {"hidden": 3},
            "candidates": ["model.hidden=1", "model.hidden=3", "model.hidden=6"],
        }
    )
    fold = Fold("without_c", (part("a"), part("b")), (part("c"),))
    assert networks.choose(cfg, {}, fold).model.hidden == 3
    assert len(seen) == 3 * 2
    assert all(subjects == {"a", "b"} for _, subjects in seen)


def test_one_trial_is_not_enough_to_choose_by():
    cfg = OmegaConf.create({"seed": 0, "candidates": ["model.hidden=1"]})
    with pytest.raises(UserError, match="two are needed"):
        networks.choose(cfg, {}, Fold("x", (part("a"),), ()))
