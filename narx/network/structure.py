"""Structure of a NARX network: delays, inputs, hidden neurons, and the layout of weights and state.

One network step is ``p_k = b2 + w2 . tanh(W1 x_k + b1)`` with the features
``x_k = (v_k, v_{k-1}, ..., p_{k-1}, p_{k-2}, ...)`` (Tham et al. 2020, eq. (7) and Fig. 2).
"""

from dataclasses import dataclass
from typing import Literal

# rational: a ratio of polynomials, within a few units of the last place; exact: the C library's
Tanh = Literal["rational", "exact"]


@dataclass(frozen=True)
class NarxStructure:
    """Sizes of a NARX network, and the order of its weights and of its state.

    The flat weight vector holds ``W1`` row by row (one row per hidden neuron, columns in the order
    of the features), ``b1``, ``w2`` and ``b2``. The state holds past values for the next step:
    ``v_{k-1}, v_{k-2}, ...`` (all inputs of a sample together), then ``p_{k-1}, p_{k-2}``.

    Parameters
    ----------
    hidden : int
        Hidden neurons (tanh).
    n_inputs : int
        Input channels.
    input_lags : int
        Input samples used by a step, including the current one: 2 means ``v_k`` and ``v_{k-1}``.
    output_lags : int
        Past outputs used by a step.

    Raises
    ------
    ValueError
        If a size is not a positive integer.
    """

    hidden: int = 3
    n_inputs: int = 1
    input_lags: int = 2
    output_lags: int = 2

    def __post_init__(self) -> None:
        for name in ("hidden", "n_inputs", "input_lags", "output_lags"):
            value = getattr(self, name)
            if int(value) != value or value < 1:
                raise ValueError(f"{name} is {value!r}, expected a positive integer")

    @property
    def n_input_features(self) -> int:
        """Features that come from the inputs."""
        return self.n_inputs * self.input_lags

    @property
    def n_features(self) -> int:
        """Features of one step, from inputs and outputs."""
        return self.n_input_features + self.output_lags

    @property
    def n_weights(self) -> int:
        """Length of the flat weight vector."""
        return self.hidden * (self.n_features + 2) + 1

    @property
    def n_input_state(self) -> int:
        """Past input values in the state."""
        return self.n_inputs * (self.input_lags - 1)

    @property
    def n_state(self) -> int:
        """Length of the state vector."""
        return self.n_input_state + self.output_lags

    @property
    def w1(self) -> slice:
        """Slice of ``W1`` (row-major) in the flat weight vector."""
        return slice(0, self.hidden * self.n_features)

    @property
    def b1(self) -> slice:
        """Slice of ``b1`` in the flat weight vector."""
        return slice(self.w1.stop, self.w1.stop + self.hidden)

    @property
    def w2(self) -> slice:
        """Slice of ``w2`` in the flat weight vector."""
        return slice(self.b1.stop, self.b1.stop + self.hidden)

    @property
    def b2(self) -> int:
        """Index of ``b2`` in the flat weight vector."""
        return self.n_weights - 1

    @property
    def sizes(self) -> tuple[int, int, int, int]:
        """Hidden neurons, inputs, input lags and output lags, for the kernels."""
        return self.hidden, self.n_inputs, self.input_lags, self.output_lags
