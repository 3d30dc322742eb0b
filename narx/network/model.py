"""The NARX network as a torch module: rates in rad/s to angles in rad, normalised internally."""

from typing import Any

import torch
from torch import Tensor, nn

from narx.errors import UserError
from narx.kinematics.rate_unit import warn_of_degrees
from narx.network.cell import NarxCell
from narx.network.closed_loop import closed_loop
from narx.network.coupled_loop import coupled_closed_loop
from narx.network.kernel_arrays import compiled_for
from narx.network.normalisation import Normalisation
from narx.network.structure import NarxStructure
from narx.settings import Flag, checked


class Narx(nn.Module):
    """One small recurrent network, run in closed loop on all three axes of a segment.

    ``p_k = b2 + w2 . tanh(W1 (v_k, v_{k-1}, p_{k-1}, p_{k-2}) + b1)`` in normalised units (Tham
    et al., eqs. (7) and (8)); by default 4 inputs, 3 tanh neurons, 1 output: 19 weights.

    Parameters
    ----------
    sampling_rate_hz : float
        Sampling rate for which the recurrence holds.
    normalisation : Normalisation
        Offsets and scales of rate and angle.
    structure : NarxStructure
        Delays and hidden neurons; one input channel per axis.
    odd : bool
        Keep the biases at zero: zero input gives zero output, and negated rates give negated
        angles.
    coupled : bool
        Convert gyroscope rates to rates of the angles with the estimated tilt; False treats the
        axes independently, as in the paper.

    Attributes
    ----------
    weights : torch.nn.Parameter, shape (P,)
        Flat (`NarxStructure`), float64, shared by the axes.

    Raises
    ------
    ValueError
        If the normalisation of an odd or coupled network has offsets.
    """

    @checked
    def __init__(
        self,
        sampling_rate_hz: float,
        normalisation: Normalisation,
        structure: NarxStructure | None = None,
        odd: Flag = True,
        coupled: Flag = True,
    ) -> None:
        super().__init__()
        self.structure = structure or NarxStructure()
        if self.structure.n_inputs != 1:
            raise ValueError("each axis has one input, its rate")
        offsets = normalisation.rate_offset_rad_s, normalisation.angle_offset_rad
        if (odd or coupled) and any(offsets):
            raise ValueError(
                f"an odd or coupled network needs a normalisation without offsets, got {offsets}"
            )
        self.sampling_rate_hz = float(sampling_rate_hz)
        self.normalisation = normalisation
        self.odd = odd
        self.coupled = coupled
        self.weights = nn.Parameter(torch.zeros(self.structure.n_weights, dtype=torch.float64))

    @property
    def trainable(self) -> Tensor:
        """Trainable weights, shape (P,), bool."""
        mask = torch.ones(self.structure.n_weights, dtype=torch.bool)
        if self.odd:
            mask[self.structure.b1] = False
            mask[self.structure.b2] = False
        return mask

    def initial_state(
        self,
        angles_rad: Tensor,
        previous_angles_rad: Tensor | None = None,
        rates_rad_s: Tensor | None = None,
    ) -> Tensor:
        """Return the state of a network that has been at a given angle.

        Parameters
        ----------
        angles_rad : Tensor, shape (..., 3)
            Angle relative to the posture at the sample before the first.
        previous_angles_rad : Tensor, shape (..., 3), optional
            Angle one sample earlier; the same if not given. Longer delays repeat the last one.
        rates_rad_s : Tensor, shape (..., 3), optional
            Angular rate at the sample before the first; zero if not given.

        Returns
        -------
        Tensor, shape (..., 3, n_state)
            Normalised state.
        """
        scaled, structure = self.normalisation, self.structure
        previous = angles_rad if previous_angles_rad is None else previous_angles_rad
        outputs = torch.stack([angles_rad, *[previous] * (structure.output_lags - 1)], dim=-1)
        rates = torch.zeros_like(angles_rad) if rates_rad_s is None else rates_rad_s
        inputs = rates.unsqueeze(-1).expand(*rates.shape, structure.n_input_state)
        return torch.cat(
            [
                (inputs - scaled.rate_offset_rad_s) / scaled.rate_scale_rad_s,
                (outputs - scaled.angle_offset_rad) / scaled.angle_scale_rad,
            ],
            dim=-1,
        )

    def forward(
        self,
        axis_rates: Tensor,
        state: Tensor | None = None,
        posture: Tensor | None = None,
        axis_scale: Tensor | None = None,
    ) -> tuple[Tensor, Tensor]:
        """Run in closed loop.

        Parameters
        ----------
        axis_rates : Tensor, shape (..., N, 3)
            Gyroscope about the clinical axes, rad/s.
        state : Tensor, shape (..., 3, n_state), optional
            State after an earlier part; zero if not given (Tham et al., II-B3).
        posture : Tensor, shape (..., 3), optional
            Angle at a network output of zero, rad; zero if not given.
        axis_scale : Tensor, shape (3,), optional
            Amplitude of each axis relative to the trained one: divides its rate and multiplies its
            angle. One if not given.

        Returns
        -------
        angles : Tensor, shape (..., N, 3)
            Sagittal, frontal and transverse, rad.
        state : Tensor, shape (..., 3, n_state)
            State to continue from.
        """
        scaled, structure = self.normalisation, self.structure
        if axis_rates.ndim < 2 or axis_rates.shape[-1] != 3:
            raise UserError(
                f"axis_rates has shape {tuple(axis_rates.shape)}, expected (..., N, 3): gyroscope "
                "about the sagittal, frontal and transverse axis, rad/s"
            )
        if compiled_for(axis_rates):
            warn_of_degrees(axis_rates.detach().numpy(), "axis_rates")
        axis_rates = axis_rates.to(self.weights.dtype)
        lead = axis_rates.shape[:-2]
        if state is None:
            state = axis_rates.new_zeros(*lead, 3, structure.n_state)
        if posture is None:
            posture = axis_rates.new_zeros(*lead, 3)
        relative = axis_rates.new_ones(3) if axis_scale is None else axis_scale
        if self.coupled:
            angles, state = coupled_closed_loop(
                self.weights,
                axis_rates,
                state,
                posture,
                rate_scale=scaled.rate_scale_rad_s * relative,
                angle_scale=scaled.angle_scale_rad * relative,
                structure=structure,
            )
            return angles, state
        inputs = (axis_rates / relative - scaled.rate_offset_rad_s) / scaled.rate_scale_rad_s
        outputs, state = closed_loop(
            self.weights, inputs.transpose(-1, -2).unsqueeze(-1), state, structure=structure
        )
        angles = outputs.transpose(-1, -2) * scaled.angle_scale_rad + scaled.angle_offset_rad
        return angles * relative + posture.unsqueeze(-2), state

    def cell(self, axis_scale: Tensor | None = None) -> NarxCell:
        """Return the network's single step, for streams and exports.

        Parameters
        ----------
        axis_scale : Tensor, shape (3,), optional
            As in `forward`.

        Returns
        -------
        NarxCell
            Step with a copy of the weights.
        """
        scaled, structure = self.normalisation, self.structure
        relative = torch.ones(3, dtype=torch.float64) if axis_scale is None else axis_scale
        return NarxCell(
            self.weights.detach().clone(),
            structure.hidden,
            structure.input_lags,
            structure.output_lags,
            self.coupled,
            scaled.rate_offset_rad_s * relative,
            scaled.rate_scale_rad_s * relative,
            scaled.angle_offset_rad * relative,
            scaled.angle_scale_rad * relative,
        )

    def extra_repr(self) -> str:
        """Describe the network for `repr`.

        Returns
        -------
        str
            Sizes, kind, sampling rate and scales.
        """
        structure, scaled = self.structure, self.normalisation
        kind = ", ".join(
            [
                "odd" if self.odd else "with biases",
                "coupled axes" if self.coupled else "single axes",
            ]
        )
        return (
            f"{structure.hidden} tanh neurons, {structure.input_lags} input and "
            f"{structure.output_lags} output lags, {structure.n_weights} weights, {kind}, "
            f"{self.sampling_rate_hz:g} Hz, scales {scaled.rate_scale_rad_s:.3g} rad/s and "
            f"{scaled.angle_scale_rad:.3g} rad"
        )

    def get_extra_state(self) -> dict[str, Any]:
        """Add everything except the weights to the state dictionary.

        Returns
        -------
        dict
            As `to_config`.
        """
        return self.to_config()

    def set_extra_state(self, state: dict[str, Any]) -> None:
        """Refuse weights of a network with different scales, sampling rate or type.

        Parameters
        ----------
        state : dict
            From `get_extra_state`.

        Raises
        ------
        UserError
            If the networks differ; the message names the difference.
        """
        own = self.to_config()
        for name, value in own.items():
            if state.get(name) != value:
                raise UserError(
                    f"load_state_dict: these weights are of a network with {name}={state.get(name)}"
                    f", this one has {value}; Narx.from_config creates the matching network"
                )

    def to_config(self) -> dict[str, Any]:
        """Describe everything except the weights, for checkpoints.

        Returns
        -------
        dict
            Plain numbers and strings, for `from_config`.
        """
        return {
            "sampling_rate_hz": self.sampling_rate_hz,
            "normalisation": vars(self.normalisation).copy(),
            "structure": vars(self.structure).copy(),
            "odd": self.odd,
            "coupled": self.coupled,
        }

    @classmethod
    def from_config(cls, config: dict[str, Any]) -> "Narx":
        """Build a network from its description.

        Parameters
        ----------
        config : dict
            From `to_config`.

        Returns
        -------
        Narx
            With zero weights.

        Raises
        ------
        ValueError
            If a field is missing, unknown, or of another type.
        """
        expected = {"sampling_rate_hz", "normalisation", "structure", "odd", "coupled"}
        if set(config) != expected:
            raise ValueError(
                f"fields of the network are {', '.join(sorted(config))}, expected "
                f"{', '.join(sorted(expected))}"
            )
        if not (isinstance(config["odd"], bool) and isinstance(config["coupled"], bool)):
            raise ValueError("'odd' and 'coupled' of the network must be true or false")
        return cls(
            config["sampling_rate_hz"],
            Normalisation(**config["normalisation"]),
            NarxStructure(**config["structure"]),
            config["odd"],
            config["coupled"],
        )
