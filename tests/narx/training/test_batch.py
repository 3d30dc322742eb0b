"""The state in which the teacher hands over to the network."""

import numpy as np
import pytest
import torch

from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.structure import NarxStructure
from narx.training.batch import batch
from narx.windows.sequences import TrainingSequence

RATE_HZ = 50.0


def test_the_teacher_moved_with_the_first_rate_about_its_mean_angle():
    """A parabola, whose mean is not its median, continued along its first slope."""
    time_s = np.arange(40) / RATE_HZ
    target, rates = np.zeros((40, 3)), np.zeros((40, 3))
    target[:, 0], rates[:, 0] = 0.4 * time_s + time_s**2, 0.4 + 2.0 * time_s
    target[30:] = np.nan
    signals = SegmentSignals("thigh", RATE_HZ, rates, np.zeros_like(rates), None)
    model = Narx(RATE_HZ, Normalisation(1.0, 1.0), NarxStructure(3, 1, 2, 2))
    made = batch([TrainingSequence("walk", signals, target)], model, "teacher")
    mean = target[:30, 0].mean()
    assert made.posture_rad[0, 0] == pytest.approx(mean)
    # one past rate, then the angles one and two samples before the first
    expected = [0.4, -0.4 / RATE_HZ - mean, -0.8 / RATE_HZ - mean]
    torch.testing.assert_close(made.state[0, 0], torch.tensor(expected, dtype=torch.float64))
