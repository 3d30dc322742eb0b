"""What several tests of the fits compare with."""

import pytest
import torch

from narx.network.structure import NarxStructure

DEFAULT = NarxStructure()


@pytest.fixture
def one_step():
    """Predictions (B, N) of the default network from measured outputs, all samples at once."""

    def predict(weights, inputs, measured, state):
        n = inputs.shape[1]
        v = torch.cat([state[:, :1], inputs[..., 0]], dim=1)
        p = torch.cat([state[:, 1:].flip(-1), measured], dim=1)
        x = torch.stack([v[:, 1:], v[:, :n], p[:, 1 : n + 1], p[:, :n]], dim=-1)
        hidden = torch.tanh(x @ weights[DEFAULT.w1].reshape(3, 4).T + weights[DEFAULT.b1])
        return hidden @ weights[DEFAULT.w2] + weights[DEFAULT.b2]

    return predict
