"""One step of the network on all three axes, in torch operations only.

This is the reference for tests of the compiled closed loop, and the basis of every export; it
therefore uses only operations that TorchScript supports.
"""

from typing import Final

import torch
from torch import Tensor, nn

from narx.kernels.limits import COS_FRONTAL_MIN


def coupled_rates(
    axis_rates: Tensor, angles: Tensor, smallest_cos_frontal: float = COS_FRONTAL_MIN
) -> Tensor:
    """Convert gyroscope rates to the rates of change of the three angles.

    Parameters
    ----------
    axis_rates : Tensor, shape (..., 3)
        Gyroscope about the clinical axes, rad/s.
    angles : Tensor, shape (..., 3)
        Sagittal, frontal, transverse, rad.
    smallest_cos_frontal : float
        Smallest magnitude of the cosine of the frontal angle.

    Returns
    -------
    Tensor, shape (..., 3)
        As `narx.kinematics.segment_angles.coupled_rates`, but finite everywhere.
    """
    sin_s, cos_s = torch.sin(angles[..., 0]), torch.cos(angles[..., 0])
    sin_f, cos_f = torch.sin(angles[..., 1]), torch.cos(angles[..., 1])
    sign = 1.0 - 2.0 * (cos_f < 0.0).to(cos_f.dtype)
    limited = sign * torch.clamp(torch.abs(cos_f), min=smallest_cos_frontal)
    heading = (axis_rates[..., 2] * cos_s - axis_rates[..., 1] * sin_s) / limited
    return torch.stack(
        [
            axis_rates[..., 0] - sin_f * heading,
            axis_rates[..., 1] * cos_s + axis_rates[..., 2] * sin_s,
            heading,
        ],
        dim=-1,
    )


class NarxCell(nn.Module):
    """Three recurrences with shared weights, driven by the gyroscope's or the coupled rates.

    Parameters
    ----------
    weights : Tensor, shape (hidden * (n_features + 2) + 1,)
        Flat, as in `narx.network.closed_loop.NarxStructure`.
    hidden, input_lags, output_lags : int
        Size of the network.
    coupled : bool
        Whether gyroscope rates are converted to rates of the angles with the estimated tilt.
    rate_offset, rate_scale, angle_offset, angle_scale : Tensor, shape (3,)
        Normalisation per axis, rad/s and rad.
    """

    hidden: Final[int]
    input_lags: Final[int]
    output_lags: Final[int]
    coupled: Final[bool]
    weights: Tensor
    rate_offset: Tensor
    rate_scale: Tensor
    angle_offset: Tensor
    angle_scale: Tensor

    def __init__(
        self,
        weights: Tensor,
        hidden: int,
        input_lags: int,
        output_lags: int,
        coupled: bool,
        rate_offset: Tensor,
        rate_scale: Tensor,
        angle_offset: Tensor,
        angle_scale: Tensor,
    ) -> None:
        super().__init__()
        self.hidden = hidden
        self.input_lags = input_lags
        self.output_lags = output_lags
        self.coupled = coupled
        self.register_buffer("weights", weights)
        self.register_buffer("rate_offset", rate_offset)
        self.register_buffer("rate_scale", rate_scale)
        self.register_buffer("angle_offset", angle_offset)
        self.register_buffer("angle_scale", angle_scale)

    def forward(self, axis_rates: Tensor, state: Tensor, posture: Tensor) -> tuple[Tensor, Tensor]:
        """Advance by one sample.

        Parameters
        ----------
        axis_rates : Tensor, shape (..., 3)
            Gyroscope about the clinical axes, rad/s.
        state : Tensor, shape (..., 3, input_lags - 1 + output_lags)
            Per axis past inputs, then past outputs, newest first, normalised.
        posture : Tensor, shape (..., 3)
            Angle at a network output of zero, rad.

        Returns
        -------
        angles : Tensor, shape (..., 3)
            Sagittal, frontal, transverse, rad.
        state : Tensor
            State for the next sample.
        """
        past = self.input_lags - 1
        offset = self.angle_offset + posture
        rates = axis_rates
        if self.coupled:
            # extrapolated to the time of the sample: with the tilt of the previous sample, the lag
            # would act like a bias wherever tilt and turn are correlated
            output = state[..., past]
            if self.output_lags > 1:
                output = 2.0 * output - state[..., past + 1]
            angles = output * self.angle_scale + offset
            rates = coupled_rates(axis_rates, angles)
        rate = ((rates - self.rate_offset) / self.rate_scale).unsqueeze(-1)
        features = torch.cat([rate, state], dim=-1)
        n_features = self.input_lags + self.output_lags
        split = self.hidden * n_features
        first = self.weights[:split].view(self.hidden, n_features)
        bias = self.weights[split : split + self.hidden]
        second = self.weights[split + self.hidden : split + 2 * self.hidden]
        output = torch.tanh(features @ first.t() + bias) @ second + self.weights[-1]
        new_state = torch.cat(
            [features[..., :past], output.unsqueeze(-1), state[..., past:-1]], dim=-1
        )
        return output * self.angle_scale + offset, new_state
