"""Networks of other sizes than the default's share machine code."""

import pytest
import torch

from narx.kernels import loops
from narx.network.closed_loop import closed_loop, closed_loop_by_torch
from narx.network.structure import NarxStructure

pytestmark = pytest.mark.skipif(not loops.AVAILABLE, reason="nothing is compiled")


@pytest.mark.parametrize(
    "structures",
    [
        [NarxStructure(hidden=n) for n in (2, 5)],
        [NarxStructure(2, 1, 1, 3), NarxStructure(3, 2, 3, 1)],
    ],
    ids=["any number of neurons", "any delays and inputs"],
)
def test_machine_code_serves_several_structures(structures):
    inputs = torch.sin(torch.arange(20.0, dtype=torch.float64))[:, None]
    codes = []
    for structure in structures:
        weights = torch.linspace(-0.5, 0.5, structure.n_weights, dtype=torch.float64)
        x = inputs.expand(20, structure.n_inputs)
        found, _ = closed_loop(weights, x, structure=structure)
        state = x.new_zeros(structure.n_state)
        expected, _ = closed_loop_by_torch(weights, x, state, structure=structure)
        torch.testing.assert_close(found, expected, rtol=0.0, atol=1e-12)
        codes.append(len(loops.axis_loop.run.signatures))
    assert codes[0] == codes[1]
