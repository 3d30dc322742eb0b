"""A network on disk comes back as it was; another file is refused in one line."""

import pickle

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.inference import checkpoint as checkpoints
from narx.inference.checkpoint import Checkpoint
from narx.inference.start_up import StartUp
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.structure import NarxStructure


@pytest.fixture
def checkpoint():
    model = Narx(
        94.3, Normalisation(3.0, 0.5, 0.1, -0.05, 1.3), NarxStructure(2, 1, 2, 3), False, False
    )
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        model.weights.copy_(0.3 * torch.randn(len(model.weights), generator=generator))
    return Checkpoint(
        model,
        StartUp(duration_s=1.5, averaging_s=0.7, leak_rad_s=0.2, settling_gain=1.0, settling_s=0.3),
        "own",
        (0.1, 0.2, 0.3),
        (0.4, 0.5, 0.6),
        {"trained_on": ["a", "b"], "report": {"cost": 0.5, "restarts": {"best": 1}}},
        7.5,
    )


@pytest.fixture
def path(checkpoint, tmp_path):
    checkpoints.save(checkpoint, tmp_path / "network.pt")
    return tmp_path / "network.pt"


def test_everything_comes_back(checkpoint, path):
    again = checkpoints.load(path)
    assert torch.equal(again.model.weights, checkpoint.model.weights)
    assert again.model.to_config() == checkpoint.model.to_config()
    for name in (
        "start_up", "axis_scaling", "error_std_rad", "start_std_rad", "history", "washout_s",
    ):  # fmt: skip
        assert getattr(again, name) == getattr(checkpoint, name)
    rates = np.random.default_rng(0).normal(size=(300, 3))
    signals = SegmentSignals("thigh", 94.3, rates, np.zeros_like(rates), np.zeros(3))
    np.testing.assert_array_equal(
        again.method().estimate(signals), checkpoint.method().estimate(signals)
    )
    std = again.method().standard_deviation(signals)
    np.testing.assert_array_equal(std[[7, -1]], [[0.4, 0.5, 0.6], [0.1, 0.2, 0.3]])
    assert [entry.name for entry in path.parent.iterdir()] == ["network.pt"]


def test_saving_again_writes_the_same(checkpoint, path):
    again = checkpoints.load(path)
    checkpoints.save(again, path.with_name("again.pt"))
    first, second = (torch.load(p, weights_only=True) for p in (path, path.with_name("again.pt")))
    assert torch.equal(first.pop("weights"), second.pop("weights"))
    assert first == second


def test_the_same_checkpoint_is_the_same_file(checkpoint, path, tmp_path):
    other = tmp_path / "of another name.pt"
    checkpoints.save(checkpoint, other)
    assert other.read_bytes() == path.read_bytes()


def test_it_holds_plain_data_alone(path):
    content = torch.load(path, weights_only=True)
    assert set(content) == {
        "model", "weights", "start_up", "axis_scaling", "error_std_rad", "start_std_rad",
        "history", "washout_s",
    }  # fmt: skip


def test_a_file_from_before_a_choice_runs_without_it(checkpoint, path):
    content = torch.load(path, weights_only=True)
    del content["washout_s"], content["start_std_rad"], content["start_up"]["averaging_begin_s"]
    torch.save(content, path)
    again = checkpoints.load(path)
    # the posture was averaged over the last part of the start-up
    assert again.start_up.averaged_from_s == pytest.approx(1.5 - 0.7)
    assert again.washout_s is None
    assert again.start_std_rad is None
    assert again.error_std_rad == checkpoint.error_std_rad


class Code:
    """What a hostile pickle would do."""

    def __reduce__(self):
        return (exec, ("raise SystemExit('code of a file was run')",))


def truncated(path):
    path.write_bytes(path.read_bytes()[:700])


def empty(path):
    path.write_bytes(b"")


def text(path):
    path.write_text("time_s,gyroscope_x_rad_s\n0.0,0.1\n")


def hostile(path):
    path.write_bytes(pickle.dumps(Code()))


def changed(**changes):
    def change(path):
        content = torch.load(path, weights_only=True)
        torch.save({**content, **changes}, path)

    return change


def without_weights(path):
    content = torch.load(path, weights_only=True)
    del content["weights"]
    torch.save(content, path)


@pytest.mark.parametrize(
    "damage",
    [
        truncated,
        empty,
        text,
        hostile,
        without_weights,
        changed(weights=torch.zeros(4)),
        changed(model={"format": 99}),
        changed(start_up={"duration_s": 1.0, "unknown": 2.0}),
        changed(axis_scaling="other"),
        changed(washout_s=0.0),
        lambda path: torch.save([1, 2, 3], path),
    ],
)
def test_another_file_is_refused_in_one_line(path, damage):
    damage(path)
    with pytest.raises(UserError, match=r"checkpoint: '.*network\.pt' is not a network") as error:
        checkpoints.load(path)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there(tmp_path):
    for missing in (tmp_path / "none.pt", tmp_path):
        with pytest.raises(UserError, match=r"^checkpoint: no file '"):
            checkpoints.load(missing)
