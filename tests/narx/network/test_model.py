"""The network as a module: pieces, single steps, symmetry, scales, configuration."""

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.structure import NarxStructure

SHAPES = {
    "default": {},
    "biases": {"odd": False},
    "axis_by_axis": {"coupled": False},
    "offsets": {"odd": False, "coupled": False, "offsets": (0.1, -0.05)},
    "long_delays": {"structure": NarxStructure(2, 1, 4, 3)},
    "short_delays": {"structure": NarxStructure(5, 1, 1, 1), "odd": False},
}


def network(offsets=(0.0, 0.0), structure=None, odd=True, coupled=True):
    model = Narx(100.0, Normalisation(3.0, 0.5, *offsets), structure, odd, coupled)
    generator = torch.Generator().manual_seed(0)
    weights = 0.4 * torch.randn(model.weights.shape, generator=generator, dtype=torch.float64)
    with torch.no_grad():
        model.weights.copy_(weights * model.trainable)
    return model


@pytest.fixture(params=SHAPES)
def model(request):
    return network(**SHAPES[request.param])


@pytest.fixture
def rates():
    """Two walks at once, fast enough to tip over."""
    return 2.0 * torch.randn(
        2, 120, 3, generator=torch.Generator().manual_seed(1), dtype=torch.float64
    )


POSTURE = torch.tensor([[0.3, 0.1, -0.2], [-0.2, 0.05, 0.4]], dtype=torch.float64)


def start(model):
    return model.initial_state(0.2 * torch.ones(2, 3, dtype=torch.float64))


def test_pieces_give_the_same_as_one_go(model, rates):
    with torch.no_grad():
        whole, last = model(rates, start(model), POSTURE)
        state, pieces = start(model), []
        for piece in torch.split(rates, [1, 0, 50, 69], dim=1):
            angles, state = model(piece, state, POSTURE)
            pieces.append(angles)
    torch.testing.assert_close(torch.cat(pieces, dim=1), whole, atol=1e-12, rtol=0)
    torch.testing.assert_close(state, last, atol=1e-12, rtol=0)
    assert whole.std(dim=1).min() > 0.01


@pytest.mark.parametrize("axis_scale", [None, (1.0, 0.4, 2.5)])
def test_stepping_the_cell_gives_the_same_as_one_go(model, rates, axis_scale):
    scale = None if axis_scale is None else torch.tensor(axis_scale, dtype=torch.float64)
    cell, state, steps = model.cell(scale), start(model), []
    with torch.no_grad():
        whole, last = model(rates, state, POSTURE, scale)
        for sample in rates.unbind(1):
            angles, state = cell(sample, state, POSTURE)
            steps.append(angles)
    # the compiled loop takes tanh, sine and cosine from rational approximations
    torch.testing.assert_close(torch.stack(steps, dim=1), whole, atol=1e-10, rtol=0)
    torch.testing.assert_close(state, last, atol=1e-10, rtol=0)


def test_without_a_state_it_starts_from_zero(model, rates):
    zero = torch.zeros(2, 3, model.structure.n_state, dtype=torch.float64)
    with torch.no_grad():
        angles, _ = model(rates)
        explicit, _ = model(rates, zero, torch.zeros(2, 3, dtype=torch.float64))
    torch.testing.assert_close(angles, explicit, atol=0, rtol=0)


def test_an_odd_network_mirrors_motion_that_is_mirrored(rates):
    with torch.no_grad():
        alone = network(coupled=False)
        torch.testing.assert_close(alone(-rates)[0], -alone(rates)[0], atol=1e-12, rtol=0)
        uneven = network(odd=False, coupled=False)
        with_biases = uneven(-rates)[0] + uneven(rates)[0]
        assert with_biases.abs().max() > 0.05
        # coupled: a leg mirrored at the sagittal plane turns the other way about x and z only
        mirror = torch.tensor([1.0, -1.0, -1.0], dtype=torch.float64)
        both = network()
        torch.testing.assert_close(
            both(mirror * rates)[0], mirror * both(rates)[0], atol=1e-12, rtol=0
        )
        # and mirroring all three is no motion that a rigid body has
        assert (both(-rates)[0] + both(rates)[0]).abs().max() > 0.01


def test_zero_in_zero_out_and_the_posture_is_added():
    still = torch.zeros(2, 40, 3, dtype=torch.float64)
    for model in (network(), network(coupled=False)):
        with torch.no_grad():
            assert not model(still)[0].any()
            angles, _ = model(still, None, POSTURE)
        torch.testing.assert_close(angles, POSTURE[:, None].expand(2, 40, 3), atol=1e-15, rtol=0)


def test_only_an_odd_network_keeps_its_biases_at_zero():
    assert network().trainable.sum() == 15
    assert network(odd=False).trainable.all()
    structure = network().structure
    held = ~network().trainable
    assert held[structure.b1].all()
    assert held[structure.b2]


def test_the_scale_of_an_axis_divides_its_rate_and_multiplies_its_angle(rates):
    model = network(coupled=False)
    scale = torch.tensor([1.0, 0.4, 2.5], dtype=torch.float64)
    with torch.no_grad():
        scaled, _ = model(rates, None, None, scale)
        plain, _ = model(rates / scale)
    torch.testing.assert_close(scaled, plain * scale, atol=1e-12, rtol=0)


def test_the_state_is_what_the_network_would_have_seen():
    model = network(offsets=(0.1, -0.05), structure=NarxStructure(2, 1, 3, 3), odd=False,
                    coupled=False)  # fmt: skip
    now = torch.tensor([0.1, 0.2, 0.3], dtype=torch.float64)
    state = model.initial_state(now, now - 0.05, 10 * now)
    rate, angle = (10 * now - 0.1) / 3.0, (now + 0.05) / 0.5
    before = (now - 0.05 + 0.05) / 0.5
    expected = torch.stack([rate, rate, angle, before, before], dim=-1)
    torch.testing.assert_close(state, expected, atol=1e-15, rtol=0)


@pytest.mark.parametrize("model", ["biases", "offsets"], indirect=True)
def test_gradient_of_the_weights(model, rates):
    """A directional derivative against a central difference."""
    generator = torch.Generator().manual_seed(3)
    direction = torch.randn(model.weights.shape, generator=generator, dtype=torch.float64)

    def cost():
        return model(rates[:, :40], start(model), POSTURE)[0].square().sum()

    value = cost()
    (gradient,) = torch.autograd.grad(value, [model.weights])
    step, costs = 1e-6, []
    with torch.no_grad():
        for sign in (1.0, -2.0):
            model.weights += sign * step * direction
            costs.append(float(cost()))
    numerical = (costs[0] - costs[1]) / (2 * step)
    assert float(gradient @ direction) == pytest.approx(numerical, rel=1e-5, abs=1e-7)


def test_configuration_there_and_back(model):
    again = Narx.from_config(model.to_config())
    assert again.to_config() == model.to_config()
    assert again.weights.shape == model.weights.shape
    with pytest.raises(ValueError, match=r"fields of the network are coupled.*expected coupled"):
        Narx.from_config({**model.to_config(), "other": 0})
    with pytest.raises(ValueError, match="must be true or false"):
        Narx.from_config({**model.to_config(), "odd": 1})


def test_offsets_and_oddness_exclude_each_other():
    for odd, coupled in ((True, False), (False, True)):
        with pytest.raises(ValueError, match="needs a normalisation without offsets"):
            Narx(100.0, Normalisation(1.0, 1.0, 0.1, 0.0), None, odd, coupled)
    with pytest.raises(ValueError, match="each axis has one input"):
        Narx(100.0, Normalisation(1.0, 1.0), NarxStructure(3, 2))


def test_a_cell_does_not_follow_its_network():
    model = network()
    cell = model.cell()
    with torch.no_grad():
        model.weights.zero_()
    assert cell.weights.abs().max() > 0.1
    assert np.array_equal(cell.weights.numpy(), network().weights.detach().numpy())


def test_repr_describes_the_network():
    said = repr(Narx(100.0, Normalisation(2.0, 0.3)))
    assert "3 tanh neurons, 2 input and 2 output lags, 19 weights, odd, coupled axes" in said
    assert "100 Hz, scales 2 rad/s and 0.3 rad" in said


@pytest.mark.parametrize(
    ("other", "says"),
    [
        (Narx(100.0, Normalisation(4.0, 0.3)), "normalisation="),
        (Narx(200.0, Normalisation(2.0, 0.3)), "sampling_rate_hz=200.0, this one has 100.0"),
        (Narx(100.0, Normalisation(2.0, 0.3), coupled=False), "coupled=False"),
    ],
)
def test_weights_of_another_network_are_refused(other, says):
    own = Narx(100.0, Normalisation(2.0, 0.3))
    own.load_state_dict(Narx(100.0, Normalisation(2.0, 0.3)).state_dict())
    with pytest.raises(UserError, match=says):
        own.load_state_dict(other.state_dict())


def test_one_axis_is_not_spread_over_three():
    for shape in ((50, 1), (50,), (2, 50, 4)):
        with pytest.raises(UserError, match=r"expected .*N, 3"):
            Narx(100.0, Normalisation(2.0, 0.3))(torch.zeros(shape))
