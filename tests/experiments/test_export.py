import numpy as np
import pytest
import torch

from narx.inference import checkpoint as checkpoints
from narx.inference.checkpoint import Checkpoint
from narx.inference.start_up import StartUp
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation


@pytest.fixture
def network():
    model = Narx(50.0, Normalisation(3.0, 0.5))
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        weights = 0.4 * torch.randn(model.weights.shape, generator=generator, dtype=torch.float64)
        model.weights.copy_(weights * model.trainable)
    return Checkpoint(model, StartUp(duration_s=2.0, averaging_s=1.0))


@pytest.fixture
def saved(network, tmp_path):
    checkpoints.save(network, tmp_path / "checkpoint.pt")
    return tmp_path / "checkpoint.pt"


def test_torchscript_file_gives_the_angles_of_the_package(run_command, network, saved, tmp_path):
    output = tmp_path / "new" / "narx.pt"
    status, out, err, _ = run_command(
        "export", f"checkpoint={saved}", "format=torchscript", f"output={output}"
    )
    assert (status, err) == (0, "")
    assert str(output) in out
    assert "rad from the package" in out
    assert network.sha256[:12] in out
    rates = np.random.default_rng(0).normal(size=(300, 3))
    signals = SegmentSignals("thigh", 50.0, rates, np.zeros_like(rates))
    angles = torch.jit.load(output)(torch.from_numpy(rates)).numpy()
    np.testing.assert_allclose(angles, network.method().estimate(signals), atol=1e-8, rtol=0)
    assert [path.name for path in output.parent.iterdir()] == ["narx.pt"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "options", "files"),
    [
        ("torch_export", [], ["narx.pt2"]),
        ("c", ["precision=double"], ["narx.c", "narx.h"]),
        ("torchscript", ["precision=float", "verify=false"], ["narx.pt"]),
    ],
)
def test_other_formats(run_command, saved, tmp_path, name, options, files):
    output = tmp_path / "new" / files[0]
    status, _, err, _ = run_command(
        "export", f"checkpoint={saved}", f"format={name}", f"output={output}", *options
    )
    assert (status, err) == (0, "")
    assert sorted(path.name for path in output.parent.iterdir()) == files


@pytest.mark.parametrize(
    ("overrides", "says"),
    [
        (["format=torchscript"], "output"),
        (["format=matlab", "output=new/x"], "format is 'matlab', expected one of torchscript"),
        (["format=c", "output=new/x.pt"], "expected a name ending in .c"),
        (["format=onnx", "output=new/x.pt"], "expected a name ending in .onnx"),
        (["output=new/x.pt", "checkpoint=missing.pt"], "no file 'missing.pt'"),
        (["output=new/x.pt", "checkpoint=own.pt"], "axis_scaling is 'own'"),
        (["output=new/x.pt", "checkpoint=cut.pt"], "'cut.pt' is not a network"),
        (["output=checkpoint.pt/x.pt"], "'checkpoint.pt/x.pt' cannot be written"),
    ],
)
def test_a_mistake_is_one_line_and_leaves_nothing(
    run_command, monkeypatch, network, saved, overrides, says
):
    monkeypatch.chdir(saved.parent)
    checkpoints.save(Checkpoint(network.model, network.start_up, axis_scaling="own"), "own.pt")
    saved.with_name("cut.pt").write_bytes(saved.read_bytes()[:1000])
    status, _, err, _ = run_command("export", f"checkpoint={saved}", *overrides)
    assert status == 2
    (line,) = err.splitlines()
    assert line.startswith("error: ")
    assert says in line
    assert not saved.with_name("new").exists() or not list(saved.with_name("new").iterdir())


def test_an_export_does_not_replace_its_checkpoint(run_command, saved):
    before = saved.read_bytes()
    status, _, err, _ = run_command("export", f"checkpoint={saved}", f"output={saved}")
    assert status == 2
    assert "is also the checkpoint, expected another name" in err
    assert saved.read_bytes() == before
