"""Constants of a session: sensor positions, soft tissue, individual sensors."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from narx.simulation.body import Body
from narx.simulation.markers import Markers, draw_markers
from narx.simulation.random_numbers import stream
from narx.simulation.sensor import SensorModel, TriadErrors, draw_triad_errors
from narx.simulation.soft_tissue import SENSOR_GAIN, SoftTissue, draw_skin, draw_soft_tissue
from narx.types import FloatArray

# sources of error that can be left out of a simulation individually
ErrorSource = Literal[
    "sensor_tissue",
    "marker_tissue",
    "landmarks",
    "gyroscope_gain",
    "gyroscope_bias",
    "accelerometer",
    "movements",
]

# careful strapping: standard deviation from the nominal orientation
_STRAPPED_SD_DEG = 10.0
_PLACEMENT_SD_M = 0.015


@dataclass(frozen=True)
class Mounting:
    """Position and orientation of a sensor on its segment.

    Parameters
    ----------
    offset_m : ndarray, shape (3,)
        From the segment's proximal joint centre, in its anatomical frame.
    orientation : scipy.spatial.transform.Rotation
        Sensor to anatomical frame.
    """

    offset_m: FloatArray
    orientation: Rotation


@dataclass(frozen=True)
class Session:
    """One person with all instruments on, each mapping by segment.

    Parameters
    ----------
    mountings : dict of str to Mounting
        Positions of the sensors.
    tissues : dict of str to SoftTissue
        Tissue under the sensors.
    gyroscopes, accelerometers : dict of str to TriadErrors
        Errors of the individual sensors.
    markers : dict of str to Markers
        Optical markers.
    """

    mountings: dict[str, Mounting]
    tissues: dict[str, SoftTissue]
    gyroscopes: dict[str, TriadErrors]
    accelerometers: dict[str, TriadErrors]
    markers: dict[str, Markers]


def draw_session(
    seed: int,
    subject: str,
    body: Body,
    sensor: SensorModel,
    mounting: str,
    segments: Iterable[str],
) -> Session:
    """Draw the instruments of a session.

    Parameters
    ----------
    seed : int
        Seed of the data set.
    subject : str
        Name.
    body : Body
        Size.
    sensor : SensorModel
        Product.
    mounting : {"random", "strapped"}
        Orientation of the sensors: arbitrary, or near the nominal one.
    segments : iterable of str
        Segments with an IMU.

    Returns
    -------
    Session
        The same for the same names and seed, segment by segment.
    """
    session = Session({}, {}, {}, {}, {})
    for segment in segments:
        rng = stream(seed, subject, segment, "session")
        session.mountings[segment] = _mount(rng, segment, body, mounting)
        skin = draw_skin(stream(seed, subject, segment, "skin"), segment)
        session.tissues[segment] = draw_soft_tissue(rng, segment, SENSOR_GAIN, skin, wobbles=True)
        session.markers[segment] = draw_markers(rng, segment, skin)
        session.gyroscopes[segment] = draw_triad_errors(rng, sensor.gyroscope)
        session.accelerometers[segment] = draw_triad_errors(rng, sensor.accelerometer)
    return session


def leave_out(session: Session, sources: Collection[str]) -> Session:
    """Remove sources of error from a session; everything else stays as drawn.

    Parameters
    ----------
    session : Session
        As from `draw_session`.
    sources : collection of str
        Of `ErrorSource`; ``movements`` and the drift within a trial are not part of a session.

    Returns
    -------
    Session
        Without tissue under sensors or markers, with exact landmarks, with exact
        axes (gain) or no constant bias of gyroscope or accelerometer.
    """
    exact = np.eye(3)
    return replace(
        session,
        tissues={
            segment: tissue.still() if "sensor_tissue" in sources else tissue
            for segment, tissue in session.tissues.items()
        },
        markers={
            segment: Markers(
                markers.tissue.still() if "marker_tissue" in sources else markers.tissue,
                Rotation.identity() if "landmarks" in sources else markers.frame,
            )
            for segment, markers in session.markers.items()
        },
        gyroscopes={
            segment: TriadErrors(
                exact if "gyroscope_gain" in sources else errors.gain,
                0.0 * errors.bias if "gyroscope_bias" in sources else errors.bias,
            )
            for segment, errors in session.gyroscopes.items()
        },
        accelerometers={
            segment: TriadErrors(exact, 0.0 * errors.bias) if "accelerometer" in sources else errors
            for segment, errors in session.accelerometers.items()
        },
    )


def _mount(rng: np.random.Generator, segment: str, body: Body, mounting: str) -> Mounting:
    """Lateral thigh, shaft of the tibia (Tham et al., section II-C), back of the pelvis."""
    kind, _, side = segment.partition("_")
    outward = 1.0 if side == "left" else -1.0
    place = {
        "thigh": np.array([0.03, outward * 0.075, -0.5 * body.thigh_m]),
        "shank": np.array([0.035, -outward * 0.02, -0.4 * body.shank_m]),
        "pelvis": np.array([-0.10, 0.0, 0.08]),
    }[kind]
    place = place * [body.girth, body.girth, 1.0] + _PLACEMENT_SD_M * rng.standard_normal(3)
    # always drawn, so that the choice of mounting does not change other random numbers
    arbitrary = Rotation.from_quat(rng.standard_normal(4))
    slip = Rotation.from_rotvec(np.radians(_STRAPPED_SD_DEG) * rng.standard_normal(3))
    return Mounting(place, arbitrary if mounting == "random" else slip)
