"""Every optimizer learns a small known problem, the same from the same seed."""

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.structure import NarxStructure
from narx.training.batch import batch
from narx.training.design import NetworkDesign, train_network
from narx.training.gradient import Adam, Lbfgs
from narx.training.initial_weights import leaky_integrator_weights, random_weights
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.by_torch import products_by_torch
from narx.training.least_squares.problem import TowardsPrior
from narx.training.levenberg_marquardt import LevenbergMarquardt
from narx.training.objective import Objective
from narx.windows.sequences import TrainingSequence, hold_back

RATE_HZ = 100.0
OPTIMIZERS = {
    "levenberg_marquardt": LevenbergMarquardt(restarts=4, iterations=20),
    "lbfgs": Lbfgs(restarts=2, iterations=15),
    "adam": Adam(restarts=2, iterations=40, learning_rate=1e-3),
}


def swing(phase=0.0, seconds=20.0, rate_hz=RATE_HZ, name="walk", harmonics=1):
    """A leg that swings in the sagittal plane, and its angle from a leaky integrator's view."""
    time = np.arange(round(seconds * rate_hz)) / rate_hz
    angle, rate = np.zeros_like(time), np.zeros_like(time)
    for k in range(1, harmonics + 1):
        w = 2 * np.pi * 0.9 * k
        angle += 0.35 / k**2 * np.sin(w * time + k * phase)
        rate += 0.35 / k**2 * w * np.cos(w * time + k * phase)
    rates, target = np.zeros((len(time), 3)), np.zeros((len(time), 3))
    rates[:, 0], target[:, 0] = rate, angle
    signals = SegmentSignals("thigh", rate_hz, rates, np.zeros_like(rates), None)
    return TrainingSequence(name, signals, target)


def train(optimizer, seed=0, design=None, sequences=None, objective=None, log=None):
    training, validation = hold_back(sequences or [swing(0.3), swing(2.0)], 0.25)
    return train_network(
        training,
        validation,
        design or NetworkDesign(hidden=2),
        objective or Objective(),
        optimizer,
        np.random.default_rng(seed),
        log or (lambda iteration, numbers: None),
    )


@pytest.mark.parametrize("name", OPTIMIZERS)
def test_learns_to_integrate(name):
    told = []
    model, history = train(OPTIMIZERS[name], log=lambda *args: told.append(args))
    new = batch([swing(4.0, 15.0)], model, "teacher")
    with torch.no_grad():
        rmse_deg = np.rad2deg(np.sqrt(float(Objective().mean_square(model, new))))
    assert rmse_deg < (0.5 if name == "levenberg_marquardt" else 2.0)  # of a swing of 20 degrees
    assert not model.weights.detach()[~model.trainable].any()
    assert history["trained_on"] == ["walk"]
    assert history["training_s"] == pytest.approx(30.0)
    report = history["report"]
    assert report["iterations"] == len(report["history"]) > 0
    assert told
    assert {"cost", "gradient"} <= set(told[0][1])
    spread = report["restarts"]
    assert spread["restarts"] == OPTIMIZERS[name].restarts
    assert spread["validation_rmse_best_deg"] <= spread["validation_rmse_worst_deg"]


@pytest.mark.parametrize("name", OPTIMIZERS)
def test_same_seed_same_weights(name):
    short = type(OPTIMIZERS[name])(restarts=2, iterations=4)
    first, again, other = (train(short, seed)[0].weights for seed in (3, 3, 4))
    assert torch.equal(first, again)
    assert not torch.equal(first, other)


def test_the_kept_weights_are_no_worse_than_the_best_start():
    one = swing()
    optimizer = Adam(restarts=1, iterations=5, learning_rate=1.0)  # far too large a step
    design = NetworkDesign(hidden=2)
    model, _ = train(optimizer, sequences=[one])
    training, _ = hold_back([one], 0.25)
    start = design.untrained(training, offset_free=False)
    with torch.no_grad():
        weights = random_weights(start, np.random.default_rng(0))
        start.weights.copy_(torch.from_numpy(weights))
        rows = batch(training, start, "teacher")
        costs = [float(Objective().mean_square(network, rows)) for network in (model, start)]
    assert costs[0] <= costs[1]


def test_a_strong_prior_keeps_the_leaky_integrator():
    free, held = (
        train(LevenbergMarquardt(restarts=2, iterations=15, prior_deg2=prior))[0]
        for prior in (1e-3, 1e6)
    )
    centre = leaky_integrator_weights(held)
    distance = [
        np.abs(model.weights.detach().numpy() / np.where(centre == 0, 1, centre) - (centre != 0))
        for model in (held, free)
    ]
    assert distance[0].max() < 1e-2
    assert distance[1].max() > 2 * distance[0].max()


def test_products_of_a_prior_are_those_of_its_residuals():
    rng = np.random.default_rng(0)
    structure = NarxStructure(2)
    inputs = torch.from_numpy(rng.normal(size=(2, 60, 1)))
    targets = torch.from_numpy(rng.normal(size=(2, 60)))
    fit = NetworkFit(inputs, targets, structure=structure)
    centre, strength = rng.normal(size=(2, fit.n_weights))
    problem = TowardsPrior(fit, centre, strength**2)
    assert (problem.n_weights, problem.n_residuals) == (fit.n_weights, fit.n_residuals)
    starts = 0.3 * rng.normal(size=(3, fit.n_weights))

    def residuals(weights):
        distance = torch.from_numpy(strength) * (weights - torch.from_numpy(centre))
        return torch.cat([fit.residuals(weights).flatten(), distance])

    expected = products_by_torch(residuals, starts)
    np.testing.assert_allclose(
        np.tril(problem.products(starts)), np.tril(expected), rtol=1e-9, atol=1e-9
    )


def test_auto_takes_as_many_neurons_as_the_gyroscope_has_components():
    for harmonics in (1, 3):
        one = swing(harmonics=harmonics, seconds=40.0)
        model = NetworkDesign(hidden="auto").untrained([one], offset_free=False)
        assert model.structure.hidden == harmonics


def test_scales_are_those_of_the_sagittal_axis():
    one = swing()
    bent = TrainingSequence("bent", one.signals, one.target_rad + 0.4)
    model = NetworkDesign(normalisation="max_abs").untrained([one, bent], offset_free=False)
    rates = one.signals.axis_rates_rad_s[:, 0]
    scaled = model.normalisation
    assert scaled.rate_scale_rad_s == pytest.approx(np.abs(rates).max())
    assert scaled.angle_scale_rad == pytest.approx(0.75, abs=1e-3)
    assert scaled.rate_rms_rad_s == pytest.approx(np.sqrt(np.mean(rates**2)))
    model = NetworkDesign(normalisation="max_abs").untrained([one, bent], offset_free=True)
    assert model.normalisation.angle_scale_rad == pytest.approx(0.35, abs=1e-3)


def test_the_rest_reaches_the_optimizer():
    objective = Objective(rest_weight=1.0, rest_leak_rad_s=0.5)
    model, _ = train(LevenbergMarquardt(restarts=2, iterations=20), objective=objective)
    tilted = model.initial_state(torch.full((3,), 0.2, dtype=torch.float64))
    with torch.no_grad():
        angles, _ = model(torch.zeros(400, 3, dtype=torch.float64), tilted)
    np.testing.assert_allclose(
        angles[-1], 0.2 * np.exp(-0.5 * 4.0) * np.ones(3), atol=np.deg2rad(0.5)
    )


@pytest.mark.parametrize("hidden", [0, -1, 2.5, "many", None])
def test_a_bad_number_of_neurons_is_one_line(hidden):
    with pytest.raises(UserError, match=r"model\.hidden is '.*', expected a positive whole num"):
        NetworkDesign(hidden=hidden).untrained([swing()], offset_free=False)


@pytest.mark.parametrize("name", ["input_lags", "output_lags"])
def test_a_bad_delay_is_one_line(name):
    with pytest.raises(UserError, match=rf"model\.{name} is '0'"):
        NetworkDesign(**{name: 0}).untrained([swing()], offset_free=False)


@pytest.mark.parametrize(
    ("normalisation", "says"),
    [
        ("min_max", r"model\.normalisation is 'min_max', which has offsets"),
        ("largest", r"model\.normalisation: .*'largest' is none of min_max, max_abs, std"),
    ],
)
def test_a_normalisation_that_does_not_fit_is_one_line(normalisation, says):
    with pytest.raises(UserError, match=says):
        NetworkDesign(normalisation=normalisation).untrained([swing()], offset_free=False)
    alone = NetworkDesign(normalisation="min_max", odd=False, coupled=False)
    assert alone.untrained([swing()], offset_free=False).normalisation.rate_scale_rad_s > 0


def test_sources_of_different_rates_are_one_line():
    with pytest.raises(UserError, match="fast is sampled at 200 Hz, the network runs at 100 Hz"):
        train(Adam(restarts=1, iterations=1), sequences=[swing(), swing(rate_hz=200, name="fast")])


def test_an_unknown_stage_is_one_line():
    with pytest.raises(
        UserError, match=r"optimizer\.curriculum holds 'half', expected open, closed"
    ):
        train(LevenbergMarquardt(restarts=1, iterations=1, curriculum=("half",)))


def test_an_untrained_network_has_zero_weights():
    model = NetworkDesign().untrained([swing()], offset_free=False)
    assert isinstance(model, Narx)
    assert isinstance(model.normalisation, Normalisation)
    assert not model.weights.detach().any()
