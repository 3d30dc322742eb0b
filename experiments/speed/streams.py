"""Samples one by one: the stream of the shipped network beside its own recording and beside VQF."""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from narx.experiments.speed.peers import installed
from narx.inference.pretrained import pretrained
from narx.inference.stream import OrientationStream
from narx.method import SegmentSignals
from narx.types import FloatArray

# samples of one sensor, sensors in step
SAMPLES, SENSORS = 1000, 10_000


def works(peers: bool) -> dict[str, tuple[Callable[[], Any], float]]:
    """Make the pieces of work to time.

    Parameters
    ----------
    peers : bool
        Include VQF, where it is installed.

    Returns
    -------
    dict of str to (callable, float)
        Work by name, and the factor from its time to that of one sample of one sensor.
    """
    rng = np.random.default_rng(0)
    rates = rng.normal(size=(SAMPLES, 3))
    strides = _strides(rng)
    shipped = pretrained()
    rate_hz = shipped.model.sampling_rate_hz
    found: dict[str, tuple[Callable[[], Any], float]] = {}
    for kind, checkpoint in {"tracked": shipped, "": replace(shipped, tracker=None)}.items():
        method = checkpoint.method()
        name = f"stream_{kind}" if kind else "stream"
        one = OrientationStream(method, rate_hz)
        many = OrientationStream(method, rate_hz, n_sensors=SENSORS)
        for _ in range(2 * SAMPLES):  # until the start-up is over
            many.update(next(strides))
        signals = SegmentSignals("thigh", rate_hz, rates, np.zeros_like(rates))
        found[f"{name}.one_sensor"] = (_one_by_one(one.update, rates), 1.0 / SAMPLES)
        found[f"{name}.in_step"] = (_next(many.update, strides), 1.0 / SENSORS)
        found[f"{name}.recording"] = (partial(method.estimate, signals), 1.0 / SAMPLES)
    if peers and installed("vqf"):
        found["stream.vqf"] = (_vqf(rates, rate_hz), 1.0 / SAMPLES)
    return found


def _strides(rng: np.random.Generator) -> Iterator[FloatArray]:
    """Rates of walking legs, each in its own phase of a stride of a second, again and again."""
    phase, turns = rng.uniform(0.0, 2.0 * np.pi, size=SENSORS), 2.0 * np.pi * np.arange(100) / 100
    return itertools.cycle([_walking(phase + turn) for turn in turns])


def _walking(phase: FloatArray) -> FloatArray:
    """Rates (..., 3) of a leg, rad/s, which swings faster forward than backward."""
    sagittal = 2.4 * np.cos(phase) + 1.2 * np.cos(2.0 * phase)
    return np.stack([sagittal, 0.4 * np.cos(2.0 * phase + 0.3), 0.3 * np.cos(phase + 1.0)], axis=-1)


def _next(update: Callable[[FloatArray], Any], samples: Iterator[FloatArray]) -> Callable[[], None]:
    def work() -> None:
        update(next(samples))

    return work


def _one_by_one(update: Callable[[FloatArray], Any], samples: FloatArray) -> Callable[[], None]:
    def work() -> None:
        for sample in samples:
            update(sample)

    return work


def _vqf(rates: FloatArray, rate_hz: float) -> Callable[[], None]:
    import vqf

    filtered, force = vqf.VQF(1.0 / rate_hz), np.array([0.0, 0.0, 9.81])

    def work() -> None:
        for sample in rates:
            filtered.update(sample, force)
            filtered.getQuat6D()

    return work
