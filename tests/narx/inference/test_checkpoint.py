"""A saved network is restored exactly; an invalid file is refused with a one-line reason."""

import os
import pickle
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.inference import checkpoint as checkpoints
from narx.inference.checkpoint import Checkpoint
from narx.inference.checkpoint_archive import digest
from narx.inference.pretrained import pretrained
from narx.inference.start_up import StartUp
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.structure import NarxStructure

FIXTURES = Path(__file__).parent / "checkpoints"


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
    std = again.method().run(signals).std_rad
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


def test_it_contains_only_plain_data(path):
    content = torch.load(path, weights_only=True)
    assert set(content) == {
        "format", "model", "weights", "start_up", "axis_scaling", "error_std_rad",
        "start_std_rad", "history", "washout_s", "tracker", "sha256",
    }  # fmt: skip
    assert content["format"] == 5


@pytest.mark.parametrize(
    ("name", "averaged_from_s", "washout_s", "start_std_deg"),
    [
        ("format_1", 2.0, 300.0, 3.894),
        ("format_1_averaged_at_the_end", 4.0, 300.0, 3.894),
        ("format_1_without_washout", 4.0, None, None),
    ],
)
def test_a_file_of_an_earlier_release_runs_as_it_did(
    name, averaged_from_s, washout_s, start_std_deg
):
    checkpoint = checkpoints.load(FIXTURES / f"{name}.pt")
    assert checkpoint.start_up.averaged_from_s == averaged_from_s
    assert checkpoint.washout_s == washout_s
    std = checkpoint.start_std_rad
    assert (std and np.degrees(std[0])) == pytest.approx(start_std_deg, abs=1e-3)
    assert float(checkpoint.model.weights.detach()[15]) == pytest.approx(33.481, abs=1e-3)


def test_a_tracker_of_format_3_runs_as_it_did():
    tracker = checkpoints.load(FIXTURES / "format_3.pt").tracker
    assert tracker.known_bias_sd_deg_s == tracker.bias_sd_deg_s == 0.5


def test_a_tracker_of_format_4_has_one_mean_turn_rate_and_no_further_doubt():
    tracker = checkpoints.load(FIXTURES / "format_3.pt").tracker
    assert tracker.turn_time_s == tracker.turning_time_s == 0.5
    assert max(tracker.reopened_sd_deg, tracker.delay_s, tracker.alignment_sd_deg) <= 1e-9
    assert tracker.corrected_sd_deg == 1e6


def test_an_older_package_refuses_a_file_of_this_one(path):
    """An older package looks for the format number in the model only."""
    assert torch.load(path, weights_only=True)["model"].get("format") != 1


class Code:
    """A payload such as a malicious pickle would run."""

    def __reduce__(self):
        return (exec, ("raise SystemExit('code of a file was run')",))


class Memory:
    """A few bytes that request gigabytes."""

    def __reduce__(self):
        return (bytearray, (10**11,))


def truncated(path):
    path.write_bytes(path.read_bytes()[:700])


def empty(path):
    path.write_bytes(b"")


def text(path):
    path.write_text("time_s,gyroscope_x_rad_s\n0.0,0.1\n")


def hostile(path):
    path.write_bytes(pickle.dumps(Code()))


def rewritten(change, sealing=True):
    def damage(path):
        content = torch.load(path, weights_only=True)
        del content["sha256"]
        change(content)
        if sealing:
            content["sha256"] = digest(content)
        torch.save(content, path)

    return damage


def changed(**changes):
    return rewritten(lambda content: content.update(changes))


def within(name, **changes):
    return rewritten(lambda content: content[name].update(changes))


def scaled(**changes):
    return rewritten(lambda content: content["model"]["normalisation"].update(changes))


def without(name):
    return rewritten(lambda content: content.pop(name))


def unpickled(*objects):
    return lambda path: torch.save({"weights": objects}, path)


def compressed(path):
    content = torch.load(path, weights_only=True)
    torch.save({**content, "weights": torch.zeros(10**6, dtype=torch.float64)}, path)
    with zipfile.ZipFile(path) as archive:
        records = {record.filename: archive.read(record) for record in archive.infolist()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in records.items():
            archive.writestr(name, data)


def endless(path):
    nest = [0]
    for _ in range(60):
        nest = [nest, nest]
    rewritten(lambda content: content.update(history={"nest": nest}), sealing=False)(path)


def spread(path):
    """One number on disk that becomes a terabyte when copied."""
    torch.save({"weights": torch.zeros(1, dtype=torch.float64).expand(2**37)}, path)


def large(path):
    with path.open("ab") as stream:
        stream.truncate(2**25)


def changed_unsealed(path):
    rewritten(lambda content: content.update(washout_s=8.0, sha256="0" * 64), sealing=False)(path)


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (truncated, "not an archive"),
        (empty, "not an archive"),
        (text, "not an archive"),
        (hostile, "not an archive"),
        (large, "33554432 bytes, expected at most 16777216"),
        (compressed, "compressed"),
        (unpickled(Code()), "more than numbers, strings and tensors"),
        (unpickled(Memory()), "more than numbers, strings and tensors"),
        (spread, "more than 100000 values"),
        (endless, "more than 100000 values"),
        (lambda path: torch.save([1, 2, 3], path), "holds a list"),
        (lambda path: torch.save({1: 2}, path), "a key in it is not a string"),
        (changed_unsealed, "does not match its checksum"),
        (without("weights"), "'weights' is missing"),
        (without("washout_s"), "'washout_s' is missing"),
        (rewritten(lambda content: content["start_up"].pop("leak_rad_s")), "'leak_rad_s' is miss"),
        (changed(format=99), "format is 99, expected 5 or an older one"),
        (changed(format=True), "format is True"),
        (changed(format=1), "field 'sha256' is unknown"),
        (changed(other=1), "field 'other' is unknown"),
        (changed(model=[]), "list indices"),
        (within("model", other=1), "fields of the network"),
        (within("start_up", other=2.0), "unexpected keyword argument 'other'"),
        (changed(weights=torch.zeros(4, dtype=torch.float64)), r"shape \(4,\), expected \(15,\)"),
        (changed(weights=torch.tensor(0.0, dtype=torch.float64)), r"shape \(\)"),
        (changed(weights=torch.zeros(15)), "more than numbers"),
        (changed(weights=[0.0] * 15), "not a float64 tensor"),
        (changed(weights=torch.full((15,), np.nan, dtype=torch.float64)), "not finite"),
        (within("model", structure={"hidden": 10**12}), "expected "),
        (within("model", structure={"hidden": np.inf}), "infinity"),
        (within("model", sampling_rate_hz=-100.0), "sampling_rate_hz is -100.0, expected"),
        (within("model", sampling_rate_hz="fast"), "'fast', expected a number"),
        (scaled(rate_scale_rad_s=0.0), "rate_scale"),
        (scaled(angle_offset_rad=np.inf), "offset"),
        (within("start_up", duration_s=np.nan), "start_up.duration_s is nan, expected a number"),
        (within("start_up", duration_s=-1.0), "start_up.duration_s is -1.0, expected a number"),
        (changed(error_std_rad=(0.1, 0.2)), "error_std_rad has 2 values, expected three"),
        (changed(start_std_rad=(0.1, 0.2, -0.1)), "start_std_rad is -0.1, expected a number above"),
        (changed(axis_scaling="other"), "axis_scaling is 'other'"),
        (changed(washout_s=0.0), "washout_s is 0.0"),
        (changed(history=[]), "history is a list"),
    ],
)  # fmt: skip
def test_another_file_is_refused_in_one_line(path, damage, reason):
    damage(path)
    with pytest.raises(
        UserError, match=rf"^checkpoint: '.*network\.pt' is not a network that .*{reason}"
    ) as error:
        checkpoints.load(path)
    assert "\n" not in str(error.value)
    assert "weights_only" not in str(error.value)


@pytest.mark.parametrize("fixture", ["this_release", "format_1"])
def test_a_few_changed_bytes_are_noticed_or_change_nothing(checkpoint, path, tmp_path, fixture):
    """NARX_FUZZ_CASES=10000 is the long run."""
    if fixture != "this_release":
        path = FIXTURES / f"{fixture}.pt"
    whole, rng = path.read_bytes(), np.random.default_rng(0)
    sha256, damaged = checkpoints.load(path).sha256, tmp_path / "damaged.pt"
    messages, cases = [], int(os.environ.get("NARX_FUZZ_CASES", "150"))
    for _ in range(cases):
        data = np.frombuffer(whole, dtype=np.uint8).copy()
        at = rng.integers(len(data), size=rng.integers(1, 5))
        data[at] ^= rng.integers(1, 256, size=len(at), dtype=np.uint8)
        damaged.write_bytes(data.tobytes())
        try:
            again = checkpoints.load(damaged)
        except UserError as error:
            messages.append(str(error))
        else:
            assert again.sha256 == sha256
    assert len(messages) > cases / 2
    assert not any("\n" in message for message in messages)


def test_a_network_that_cannot_run_is_not_saved(checkpoint, tmp_path):
    with torch.no_grad():
        checkpoint.model.weights[3] = np.nan
    with pytest.raises(UserError, match="a weight of the network is not finite"):
        checkpoints.save(checkpoint, tmp_path / "nan.pt")
    assert not list(tmp_path.glob("nan*"))


def test_a_file_that_is_not_there(tmp_path):
    for missing in (tmp_path / "none.pt", tmp_path):
        with pytest.raises(UserError, match=r"^checkpoint: no file '"):
            checkpoints.load(missing)


@pytest.mark.parametrize("history", [{"a": {1, 2}}, {"a": object()}, {1: "a"}, {"a": b"x"}])
def test_a_history_that_could_not_be_read_again_is_refused(tmp_path, history):
    with pytest.raises(UserError, match=r"^checkpoint\.history: .*expected plain data$"):
        checkpoints.save(replace(pretrained(), history=history), tmp_path / "a.pt")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["file/a.pt", "a" * 300, "a\0.pt", "."])
def test_a_path_that_cannot_be_written_is_named(tmp_path, name):
    (tmp_path / "file").write_text("a file")
    with pytest.raises(UserError, match=r"^checkpoint: .* cannot be written: "):
        checkpoints.save(pretrained(), tmp_path / name)


def test_only_a_checkpoint_with_a_network_is_written(tmp_path):
    with pytest.raises(UserError, match=r"^checkpoint is a dict, expected a Checkpoint$"):
        checkpoints.save({}, tmp_path / "a.pt")
    with pytest.raises(UserError, match=r"^model is a str, expected a Narx$"):
        checkpoints.save(replace(pretrained(), model="narx"), tmp_path / "a.pt")


@pytest.mark.parametrize("smoothing", ["no", 1, None])
def test_a_flag_is_true_or_false(smoothing):
    with pytest.raises(UserError, match=r"smoothing is .*, expected True or False$"):
        pretrained().method(smoothing)
