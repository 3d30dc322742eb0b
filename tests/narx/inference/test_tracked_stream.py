"""Network and tracker sample by sample give the batch angles, also with losses."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
import torch

from narx.inference.stream import OrientationStream, Quality
from narx.inference.tracked_method import TrackedNarxMethod
from narx.inference.tracker import PostureTracker
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.initial_weights import leaky_integrator_weights

RATE_HZ = 100.0
N = 2000


def made(aided=False):
    model = Narx(RATE_HZ, Normalisation(2.0, 0.25))
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(leaky_integrator_weights(model, 0.1)))
    return TrackedNarxMethod(model, PostureTracker(aided=aided, std_scale=(1.1, 0.9, 1.2)))


METHODS = {"gyroscope": made(), "aided": made(aided=True)}


@pytest.fixture(params=METHODS)
def method(request):
    return METHODS[request.param]


def walk(time_s):
    """Rates and forces of a leg that swings after two seconds of standing, at any time."""
    turns = 2 * np.pi * 0.9 * np.asarray(time_s)[:, None]
    rates = np.array([2.4, 0.4, 0.3]) * np.cos(turns * [1.0, 2.0, 1.0] + [0.0, 0.3, 1.0])
    # faster forward than backward
    rates[:, :1] += 1.2 * np.cos(2.0 * turns)
    force = np.array([0.0, 0.0, 9.81]) + 0.5 * np.cos(turns + np.array([0.0, 1.0, 2.0]))
    return np.hstack([rates * np.clip(np.asarray(time_s)[:, None] - 2.0, 0.0, 1.0), force])


@pytest.fixture(scope="module")
def lossy():
    samples = walk(np.arange(N) / RATE_HZ)
    samples += np.random.default_rng(0).normal(scale=0.02, size=samples.shape)
    samples[np.random.default_rng(1).random(N) < 0.02] = np.nan
    samples[:2] = samples[1500:1540] = np.nan
    samples[1200, 1] = 1e30
    return samples


def whole(method, samples, start=None):
    signals = SegmentSignals("shank", RATE_HZ, samples[:, :3], samples[:, 3:], start)
    return method.estimate(signals), method.run(signals).std_rad


def test_blocks_of_any_size_are_the_whole_recording(method, lossy):
    start = np.array([0.1, -0.05, 0.2])
    angles, std = whole(method, lossy, start)
    assert np.isfinite(std[~np.isnan(angles)]).all()
    for size in (1, 7, 2000):
        stream = OrientationStream(method, RATE_HZ, initial_angles_rad=start)
        cuts = np.unique(np.random.default_rng(2).integers(0, N, size=N // size - 1))
        blocks = [stream.update_block(block) for block in np.split(lossy, cuts)]
        np.testing.assert_array_equal(np.concatenate([b.angles_rad for b in blocks]), angles)
        np.testing.assert_array_equal(np.concatenate([b.std_rad for b in blocks]), std)


def test_sensors_in_step_and_copies_are_each_alone(method, lossy):
    several = np.stack([np.roll(lossy, 37 * k, axis=0) for k in range(4)])
    stream = OrientationStream(method, RATE_HZ, n_sensors=4)
    first = stream.update(several[:, 0])
    assert first.angles_rad.shape == first.std_rad.shape == (4, 3)
    stream.update_block(several[:, 1:900])
    copies = stream, copy.deepcopy(stream), pickle.loads(pickle.dumps(stream))
    for one in copies:
        angles = one.update_block(several[:, 900:]).angles_rad
        for sensor in range(4):
            np.testing.assert_array_equal(angles[sensor], whole(method, several[sensor])[0][900:])


@pytest.mark.concurrency
def test_many_sensors_in_threads_are_each_alone(lossy):
    n, method = 600, METHODS["gyroscope"]
    many = OrientationStream(method, RATE_HZ, n_sensors=n)
    samples = np.stack([np.roll(lossy, 3 * k, axis=0)[:30, :3] for k in range(n)])
    angles = many.update_block(samples).angles_rad
    for k in (0, 255, 256, 511, 599):
        alone = OrientationStream(method, RATE_HZ).update_block(samples[k]).angles_rad
        np.testing.assert_array_equal(angles[k], alone)


def test_quality_of_every_sample(method, lossy):
    quality = OrientationStream(method, RATE_HZ).update_block(lossy).quality
    assert quality[0] == quality[1200] == quality[1520] == Quality.MISSING
    assert quality[10] == Quality.STARTING
    assert quality[1540] == Quality.AFTER_PAUSE
    # the drawn rates are not those of a leg that returns
    assert (quality[1000:1200] == Quality.DOUBTFUL).mean() > 0.9
    signals = SegmentSignals("shank", RATE_HZ, lossy[:, :3], lossy[:, 3:])
    np.testing.assert_array_equal(method.run(signals).quality, quality)
    uncorrected = replace(method.tracker, corrected_sd_deg=1e6)
    plain = TrackedNarxMethod(method.model, uncorrected).run(signals).quality
    assert (plain[1000:1200] == Quality.GOOD).mean() > 0.9


def test_lost_packets_cost_little(method):
    samples = walk(np.arange(N) / RATE_HZ)
    lost = np.random.default_rng(3).random(N) < 0.02
    angles, _ = whole(method, samples)
    difference = whole(method, np.where(lost[:, None], np.nan, samples))[0] - angles
    # when each lost sample paused the network: above a degree
    assert np.rad2deg(np.nanstd(difference, axis=0)).max() < 0.02


def test_time_stamps_change_nothing_and_stand_for_lost_packets(method, lossy):
    lossy = lossy[2:]  # stamps begin with the first sample
    angles, std = whole(method, lossy)
    times = 1.7e9 + np.arange(N - 2) / RATE_HZ
    there = np.isfinite(angles).all(axis=1)
    stream = OrientationStream(method, RATE_HZ)
    found = [stream.update(s, t) for s, t in zip(lossy[there], times[there], strict=True)]
    np.testing.assert_allclose([e.angles_rad for e in found], angles[there], atol=1e-6)
    np.testing.assert_allclose([e.std_rad for e in found], std[there], atol=1e-6)


@pytest.mark.parametrize("rate_hz", [61.0, 104.0, 200.0])
def test_another_rate_with_time_stamps_gives_the_same_angles(method, rate_hz):
    start = np.zeros(3)
    times = (np.arange(int(20 * rate_hz)) + 0.1) / rate_hz
    stream = OrientationStream(method, RATE_HZ, initial_angles_rad=start)
    estimate = stream.update_block(walk(times), times)
    ticks = np.arange(N) / RATE_HZ + times[0]
    angles, _ = whole(method, walk(ticks), start)
    expected = np.stack([np.interp(times, ticks, angles[:, axis]) for axis in range(3)], axis=1)
    error = np.rad2deg(estimate.angles_rad - expected)[times < ticks[-1]]
    # a correction is a step between two samples
    assert np.quantile(np.abs(error), 0.99) < 0.2
