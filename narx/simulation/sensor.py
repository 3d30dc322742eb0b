"""Output of an inertial sensor for a given angular rate and specific force.

Error model: misaligned and wrongly scaled axes, constant bias, bias instability (a Gauss-Markov
process) and bias random walk, white noise, low-pass filter, range, quantisation.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, lfilter, sosfilt, sosfilt_zi

from narx.errors import UserError
from narx.recordings.trial import GRAVITY_M_S2
from narx.types import FloatArray

_DEG = np.pi / 180.0


@dataclass(frozen=True)
class TriadModel:
    """Error model of three axes, in the unit of the signal (rad/s or m/s^2).

    Parameters
    ----------
    full_range : float
        Largest reading.
    scale_sd : float
        Scale error of an axis, relative, standard deviation.
    misalignment_sd_rad : float
        Angle between an axis and its nominal direction, standard deviation.
    bias_sd : float
        Constant bias of a session, standard deviation.
    instability : float
        Standard deviation of the slowly varying part of the bias.
    instability_time_s : float
        Its correlation time.
    random_walk : float
        Bias random walk, unit per square root of second.
    noise_density : float
        White noise, unit per square root of Hz.
    """

    full_range: float
    scale_sd: float
    misalignment_sd_rad: float
    bias_sd: float
    instability: float
    instability_time_s: float
    random_walk: float
    noise_density: float

    def without_drift(self) -> "TriadModel":
        """Return the same model with a constant bias.

        Returns
        -------
        TriadModel
            Without bias instability and random walk.
        """
        return replace(self, instability=0.0, random_walk=0.0)


@dataclass(frozen=True)
class SensorModel:
    """A sensor product: gyroscope, accelerometer and their sampling.

    Parameters
    ----------
    gyroscope, accelerometer : TriadModel
        Error models.
    bandwidth_hz : float
        Cut-off of the second-order low-pass filter before sampling.
    bits : int
        Resolution.
    """

    gyroscope: TriadModel
    accelerometer: TriadModel
    bandwidth_hz: float
    bits: int = 16


# sources of every number: docs/simulator.md
SENSORS = {
    "physilog": SensorModel(
        gyroscope=TriadModel(
            full_range=900 * _DEG, scale_sd=0.005, misalignment_sd_rad=0.5 * _DEG,
            bias_sd=1.0 * _DEG, instability=0.005 * _DEG, instability_time_s=100.0,
            random_walk=0.001 * _DEG, noise_density=0.05 * _DEG,
        ),
        accelerometer=TriadModel(
            full_range=11 * GRAVITY_M_S2, scale_sd=0.005, misalignment_sd_rad=0.5 * _DEG,
            bias_sd=0.01 * GRAVITY_M_S2, instability=0.0002 * GRAVITY_M_S2,
            instability_time_s=100.0, random_walk=2e-5 * GRAVITY_M_S2,
            noise_density=350e-6 * GRAVITY_M_S2,
        ),
        bandwidth_hz=100.0,
    ),
    "mpu6150": SensorModel(
        gyroscope=TriadModel(
            full_range=250 * _DEG, scale_sd=0.01, misalignment_sd_rad=0.7 * _DEG,
            bias_sd=5.0 * _DEG, instability=0.003 * _DEG, instability_time_s=100.0,
            random_walk=0.0005 * _DEG, noise_density=0.005 * _DEG,
        ),
        accelerometer=TriadModel(
            full_range=2 * GRAVITY_M_S2, scale_sd=0.01, misalignment_sd_rad=0.7 * _DEG,
            bias_sd=0.03 * GRAVITY_M_S2, instability=0.0002 * GRAVITY_M_S2,
            instability_time_s=100.0, random_walk=2e-5 * GRAVITY_M_S2,
            noise_density=400e-6 * GRAVITY_M_S2,
        ),
        bandwidth_hz=44.0,
    ),
}  # fmt: skip


def sensor_model(name: str) -> SensorModel:
    """Look up a sensor.

    Parameters
    ----------
    name : str
        ``physilog`` (Tham et al.: 900 deg/s, 11 g) or ``mpu6150`` (Han et al.: 250 deg/s, 2 g).

    Returns
    -------
    SensorModel
        Its error model.

    Raises
    ------
    UserError
        If there is no such sensor.
    """
    if name not in SENSORS:
        raise UserError(f"simulated_gait: no sensor '{name}'; known are {', '.join(SENSORS)}")
    return SENSORS[name]


@dataclass(frozen=True)
class TriadErrors:
    """One individual sensor: errors that are constant over a session.

    Parameters
    ----------
    gain : ndarray, shape (3, 3)
        From the signal along the case's axes to that along the sensor's axes.
    bias : ndarray, shape (3,)
        Constant bias.
    """

    gain: FloatArray
    bias: FloatArray


def draw_triad_errors(rng: np.random.Generator, model: TriadModel) -> TriadErrors:
    """Draw the errors of an individual sensor.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    model : TriadModel
        Product.

    Returns
    -------
    TriadErrors
        Scale errors on the diagonal of the gain, misalignments off it.
    """
    gain = model.misalignment_sd_rad * rng.standard_normal((3, 3))
    np.fill_diagonal(gain, 1.0 + model.scale_sd * rng.standard_normal(3))
    return TriadErrors(gain, model.bias_sd * rng.standard_normal(3))


def measure(
    true: FloatArray,
    rate_hz: float,
    every: int,
    model: TriadModel,
    errors: TriadErrors,
    bandwidth_hz: float,
    bits: int,
    rng: np.random.Generator,
) -> FloatArray:
    """Simulate the sensor's output for a signal.

    Parameters
    ----------
    true : ndarray, shape (N, 3)
        Signal along the case's axes.
    rate_hz : float
        Rate of `true`.
    every : int
        Take each `every`-th sample after the low-pass filter.
    model : TriadModel
        Product.
    errors : TriadErrors
        Errors of the individual sensor.
    bandwidth_hz : float
        Cut-off of the low-pass filter; limited to 0.4 of the output rate.
    bits : int
        Resolution.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    ndarray, shape (ceil(N / every), 3)
        Reading: within the range, on the grid of the converter.
    """
    n = len(true)
    # einsum: a product this narrow is slower when BLAS shares it among threads
    reading = np.einsum("nj,ij->ni", true, errors.gain)
    reading += errors.bias
    reading += model.noise_density * np.sqrt(0.5 * rate_hz) * rng.standard_normal((n, 3))
    cutoff = min(bandwidth_hz, 0.4 * rate_hz / every)
    low_pass = butter(2, cutoff, fs=rate_hz, output="sos")
    rest = sosfilt_zi(low_pass)[:, :, None] * reading[0]
    reading = sosfilt(low_pass, reading, axis=0, zi=rest)[0][::every]
    reading += _drift(len(reading), rate_hz / every, model, rng)
    step = 2.0 * model.full_range / 2**bits
    reading = np.round(reading / step)
    np.clip(reading, -(2 ** (bits - 1)), 2 ** (bits - 1) - 1, out=reading)
    return np.asarray(reading * step)


def _drift(n: int, rate_hz: float, model: TriadModel, rng: np.random.Generator) -> FloatArray:
    """Bias instability plus bias random walk."""
    decay = np.exp(-1.0 / (rate_hz * model.instability_time_s))
    kicks = rng.standard_normal((n, 3)) * model.instability * np.sqrt(1.0 - decay**2)
    kicks[0] = model.instability * rng.standard_normal(3)
    slow = lfilter([1.0], [1.0, -decay], kicks, axis=0)
    walk = np.cumsum(rng.standard_normal((n, 3)), axis=0)
    return np.asarray(slow + model.random_walk / np.sqrt(rate_hz) * walk)
