"""Second derivatives through the closed loop, and torch.func, against central differences."""

import pytest
import torch

from narx.network import Narx, NarxStructure, Normalisation
from narx.network.closed_loop import closed_loop
from narx.network.coupled_loop import coupled_closed_loop

SHAPE = NarxStructure()
SCALES = {
    "rate_scale": torch.tensor([2.0, 1.5, 3.0], dtype=torch.float64),
    "angle_scale": torch.tensor([0.5, 0.4, 0.6], dtype=torch.float64),
}


def random(*shape, seed=0):
    generator = torch.Generator().manual_seed(seed)
    return 0.5 * torch.randn(*shape, generator=generator, dtype=torch.float64)


RATES = random(2, 12, 3, seed=1)


def axis_cost(weights):
    outputs, last = closed_loop(weights, RATES[..., :1], structure=SHAPE)
    return outputs.square().sum() + last.sum()


def coupled_cost(weights):
    angles, _ = coupled_closed_loop(weights, RATES, structure=SHAPE, **SCALES)
    return angles.square().sum()


def by_differences(cost, at, step=1e-5):
    """Hessian from central differences of the compiled gradient."""
    rows = []
    for i in range(len(at)):
        gradients = []
        for sign in (1.0, -1.0):
            moved = at.clone()
            moved[i] += sign * step
            moved.requires_grad_()
            gradients.append(torch.autograd.grad(cost(moved), moved)[0])
        rows.append((gradients[0] - gradients[1]) / (2 * step))
    return torch.stack(rows)


@pytest.mark.parametrize("cost", [axis_cost, coupled_cost])
def test_the_hessian_is_that_of_the_compiled_gradient(cost):
    weights = random(SHAPE.n_weights)
    expected = by_differences(cost, weights)
    assert expected.abs().max() > 0.1
    for hessian in (
        torch.autograd.functional.hessian(cost, weights),
        torch.func.hessian(cost)(weights),
    ):
        torch.testing.assert_close(hessian, expected, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("cost", [axis_cost, coupled_cost])
def test_transforms_of_torch_func(cost):
    weights = random(SHAPE.n_weights).requires_grad_()
    (expected,) = torch.autograd.grad(cost(weights), weights)
    at = weights.detach()
    torch.testing.assert_close(torch.func.grad(cost)(at), expected, rtol=1e-10, atol=1e-12)
    torch.testing.assert_close(torch.func.jacfwd(cost)(at), expected, rtol=1e-10, atol=1e-12)
    both = torch.func.vmap(cost)(torch.stack([at, 2 * at]))
    torch.testing.assert_close(both, torch.stack([cost(at), cost(2 * at)]))


def test_mixed_second_derivatives_of_weights_and_inputs():
    weights, inputs = random(SHAPE.n_weights), random(8, 1, seed=2)

    def outputs(weights, inputs):
        return closed_loop(weights, inputs, structure=SHAPE)[0]

    both = weights.requires_grad_(), inputs.requires_grad_()
    assert torch.autograd.gradgradcheck(outputs, both)


def test_a_penalty_on_the_gradient_trains_a_module():
    """What needs a second derivative in practice: the norm of the gradient in the cost."""
    model = Narx(100.0, Normalisation(2.0, 0.5), SHAPE)
    with torch.no_grad():
        model.weights.copy_(random(SHAPE.n_weights) * model.trainable)
    cost = model(RATES)[0].square().mean()
    (gradient,) = torch.autograd.grad(cost, model.weights, create_graph=True)
    gradient.square().sum().backward()
    assert model.weights.grad is not None
    assert model.weights.grad.abs().max() > 0
