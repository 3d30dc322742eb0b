"""Bodies of the walkers: the subjects of Tham et al. (2020), Table 1, and randomly drawn ones."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from narx.errors import UserError
from narx.simulation.random_numbers import stream


@dataclass(frozen=True)
class Body:
    """Size of a walker.

    Parameters
    ----------
    height_m : float
        Standing height.
    mass_kg : float
        Body mass; a larger mass makes the legs thicker, so that sensors are farther from the bone.

    Notes
    -----
    Lengths are the fractions of height of Drillis and Contini (1966), in Winter, Biomechanics
    and Motor Control of Human Movement, 4th ed., 2009, Fig. 4.1.
    """

    height_m: float
    mass_kg: float

    @property
    def thigh_m(self) -> float:
        """Hip to knee joint centre."""
        return 0.245 * self.height_m

    @property
    def shank_m(self) -> float:
        """Knee to ankle joint centre."""
        return 0.246 * self.height_m

    @property
    def ankle_height_m(self) -> float:
        """Ankle joint centre above the ground."""
        return 0.039 * self.height_m

    @property
    def leg_m(self) -> float:
        """Hip joint centre above the ground in standing."""
        return self.thigh_m + self.shank_m + self.ankle_height_m

    @property
    def hip_distance_m(self) -> float:
        """Between the hip joint centres: about 0.1 of the height (Bell et al., 1990)."""
        return 0.1 * self.height_m

    @property
    def girth(self) -> float:
        """Thickness of the limbs relative to a body mass index of 22 kg/m^2."""
        return (self.mass_kg / self.height_m**2 / 22.0) ** 0.5


# Tham et al. (2020), Table 1
TABLE_1 = {
    "S1": Body(1.62, 48.0),
    "S2": Body(1.84, 84.0),
    "S3": Body(1.59, 49.0),
    "S4": Body(1.79, 75.0),
    "S5": Body(1.59, 55.0),
}


def subjects_of(names: Iterable[str]) -> tuple[str, ...]:
    """Write ``drawn30`` out as V1 ... V30.

    Parameters
    ----------
    names : iterable of str
        Subjects, and ``drawn<number>``.

    Returns
    -------
    tuple of str
        Each subject once.
    """
    subjects: list[str] = []
    for name in names:
        many = re.fullmatch(r"drawn([1-9][0-9]{0,3})", name)
        subjects += [f"V{k + 1}" for k in range(int(many[1]))] if many else [name]
    return tuple(dict.fromkeys(subjects))


def body_of(subject: str, seed: int) -> Body:
    """Return the body of a virtual subject.

    Parameters
    ----------
    subject : str
        ``S1`` ... ``S5`` as in Table 1 of Tham et al.; ``V1``, ``V2``, ... are drawn: height
        1.69 m with a standard deviation of 0.09 m, body mass index 23 with 2.5 kg/m^2.
    seed : int
        Seed of the data set; affects the drawn subjects only.

    Returns
    -------
    Body
        The same for the same name and seed.

    Raises
    ------
    UserError
        If the name is neither.
    """
    if subject in TABLE_1:
        return TABLE_1[subject]
    if not re.fullmatch(r"V[1-9][0-9]*", subject):
        raise UserError(
            f"simulated_gait: subject '{subject}', expected S1 ... S5 (Tham et al., Table 1) "
            "or V1, V2, ... (drawn at random)"
        )
    rng = stream(seed, subject, "body")
    height = float(rng.normal(1.69, 0.09))
    return Body(height, float(rng.normal(23.0, 2.5)) * height**2)
