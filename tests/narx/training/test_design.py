"""Every optimizer learns a small known problem, the same from the same seed."""

from dataclasses import replace
from itertools import combinations

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
from narx.training.initial_weights import leaky_integrator_weights
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.by_torch import products_by_torch
from narx.training.least_squares.problem import TowardsPrior
from narx.training.levenberg_marquardt import LevenbergMarquardt
from narx.training.objective import Objective
from narx.training.stages import closed_loop_fit
from narx.windows.sequences import TrainingSequence, hold_back

RATE_HZ = 100.0
OPTIMIZERS = {
    "levenberg_marquardt": LevenbergMarquardt(restarts=4, iterations=20),
    "lbfgs": Lbfgs(restarts=2, iterations=40),
    "adam": Adam(restarts=2, iterations=250),
}


def swing(phase=0.0, seconds=20.0, rate_hz=RATE_HZ, name="walk", harmonics=1):
    """Sagittal leg swing and its angle as a leaky integrator gives it."""
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


def train(optimizer, seed=0, design=None, sequences=None, objective=None, log=None, start=None):
    training, validation = hold_back(sequences or [swing(0.3), swing(2.0)], 0.25)
    return train_network(
        training,
        validation,
        design or NetworkDesign(hidden=2),
        objective or Objective(),
        optimizer,
        np.random.default_rng(seed),
        log or (lambda iteration, numbers: None),
        start,
    )


@pytest.mark.parametrize("name", OPTIMIZERS)
def test_learns_to_integrate(name):
    told = []
    model, history = train(OPTIMIZERS[name], log=lambda *args: told.append(args))
    new = batch([swing(4.0, 15.0)], model, "teacher")
    problem, unit_deg2 = closed_loop_fit(model, new, Objective(), "test")
    squares = problem.products(model.weights.detach().numpy()[None])[0, -1, -1]
    rmse_deg = np.sqrt(squares * unit_deg2 / problem.total_weight)
    assert rmse_deg < 0.5  # of a swing of 20 degrees
    assert not model.weights.detach()[~model.trainable].any()
    assert history["trained_on"] == ["walk"]
    assert history["training_s"] == pytest.approx(30.0)
    report = history["report"]
    assert report["iterations"] == len(report["history"]) > 0
    spread = report["restarts"]
    assert spread["restarts"] == OPTIMIZERS[name].restarts
    assert spread["validation_rmse_best_deg"] <= spread["validation_rmse_worst_deg"]
    # every restart under its own name, in the unit of the report
    tags = {tag for _, numbers in told for tag in numbers}
    assert tags == {f"restart_{i:02d}/cost_deg2" for i in range(OPTIMIZERS[name].restarts)}
    logged = [cost for _, numbers in told for cost in numbers.values()]
    assert min(row["cost_deg2"] for row in report["history"]) >= 0.99 * min(logged)


@pytest.mark.parametrize("name", OPTIMIZERS)
@pytest.mark.parametrize("stage", ["open", "closed"])
def test_the_cost_falls_by_a_factor(name, stage):
    only = replace(OPTIMIZERS[name], curriculum=(stage,), prior_deg2=0.0, restarts=1)
    _, history = train(only, objective=Objective(rest_weight=0.0))
    costs = [row["cost_deg2"] for row in history["report"]["history"]]
    assert min(costs) < 0.1 * costs[0]


@pytest.mark.parametrize("name", OPTIMIZERS)
def test_all_ends_where_levenberg_marquardt_does(name):
    reference, model = (
        train(optimizer)[1]["report"]["restarts"]["validation_rmse_best_deg"]
        for optimizer in (OPTIMIZERS["levenberg_marquardt"], OPTIMIZERS[name])
    )
    assert model < 1.1 * reference


@pytest.mark.parametrize("name", OPTIMIZERS)
def test_other_settings_give_another_network(name):
    optimizer = replace(OPTIMIZERS[name], restarts=1)
    few = 30 if name == "adam" else 3
    short, none, free, rash = (
        train(other)[0].weights
        for other in (
            replace(optimizer, iterations=few),
            replace(optimizer, iterations=0),
            replace(optimizer, iterations=few, prior_deg2=100.0),
            replace(optimizer, iterations=few, learning_rate=0.1)
            if name == "adam"
            else replace(optimizer, iterations=few, curriculum=("closed",)),
        )
    )
    for one, other in combinations((short, none, free, rash), 2):
        assert not torch.allclose(one, other, rtol=1e-6)


@pytest.mark.parametrize("name", OPTIMIZERS)
def test_same_seed_same_weights(name):
    short = type(OPTIMIZERS[name])(restarts=2, iterations=4)
    first, again, other = (train(short, seed)[0].weights for seed in (3, 3, 4))
    assert torch.equal(first, again)
    assert not torch.equal(first, other)


@pytest.mark.parametrize("coupled", [True, False])
@pytest.mark.parametrize("stage", ["open", 7, "closed"])
def test_torch_operations_on_a_device_have_the_cost_of_the_compiled_loop(coupled, stage):
    objective = Objective(offset_free=coupled, rest_weight=0.1, rest_leak_rad_s=50.0)
    firsts = [
        train(
            Lbfgs(restarts=1, iterations=1, curriculum=(stage,), device=device),
            design=NetworkDesign(hidden=2, coupled=coupled),
            sequences=[swing(0.3, 3.0), swing(2.0, 3.0)],
            objective=objective,
        )[1]["report"]["history"][0]
        for device in (None, "cpu")
    ]
    assert firsts[0] == pytest.approx(firsts[1], rel=1e-6)
    assert firsts[0]["gradient"] > 0


@pytest.mark.parametrize("name", OPTIMIZERS)
def test_continues_from_a_trained_network(name):
    optimizer = replace(OPTIMIZERS[name], iterations=3, restarts=1)
    trained, before = train(OPTIMIZERS["levenberg_marquardt"])
    further, after = train(optimizer, start=trained)
    first = after["report"]["history"][0]
    assert first["stage"] == 0.0  # the last stage alone
    assert first["cost_deg2"] == pytest.approx(
        before["report"]["history"][-1]["cost_deg2"], rel=1e-6
    )
    assert further.normalisation == trained.normalisation
    with pytest.raises(UserError, match=r"network with hidden=2, model\.hidden is 3"):
        train(optimizer, start=trained, design=NetworkDesign(hidden=3))


def test_steps_that_are_too_large_do_no_harm():
    histories = [
        train(Adam(restarts=1, iterations=n, learning_rate=10.0, curriculum=("closed",)))[1]
        for n in (1, 6)
    ]
    first, last = (history["report"]["restarts"] for history in histories)
    assert last["validation_rmse_best_deg"] <= 1.1 * first["validation_rmse_best_deg"]


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


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"hidden": 0}, "model.hidden is 0, expected a whole number from 1 to"),
        ({"hidden": 2.5}, "model.hidden is 2.5"),
        ({"hidden": "many"}, "model.hidden is 'many'"),
        ({"hidden": True}, "model.hidden is true"),
        ({"input_lags": 0}, "model.input_lags is 0"),
        ({"output_lags": 10**6}, "model.output_lags is 1000000, expected a whole number from 1"),
        ({"hidden": 40, "input_lags": 20}, "have 961 weights, at most 600"),
        ({"coupled": "maybe"}, "model.coupled is 'maybe', expected true or false"),
        ({"odd": 2}, "model.odd is 2"),
        ({"initial_state": "foo"}, "model.initial_state is 'foo', expected one of teacher, zero"),
        ({"normalisation": "min_max"}, "model.normalisation is 'min_max', which has offsets"),
        ({"normalisation": "largest"}, "'largest', expected one of min_max, max_abs, std"),
    ],
)
def test_a_design_refuses_nonsense_where_it_is_made(values, says):
    with pytest.raises(UserError, match=says):
        NetworkDesign(**values)


def test_min_max_is_for_networks_with_biases_on_single_axes():
    alone = NetworkDesign(normalisation="min_max", odd=False, coupled=False)
    assert alone.untrained([swing()], offset_free=False).normalisation.rate_scale_rad_s > 0


@pytest.mark.parametrize("optimizer", [LevenbergMarquardt, Lbfgs, Adam])
@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"restarts": 0}, "optimizer.restarts is 0, expected a whole number from 1 to"),
        ({"iterations": -1}, "optimizer.iterations is -1"),
        ({"prior_deg2": float("nan")}, "optimizer.prior_deg2 is nan, expected a number of at"),
        ({"cost_change": 2}, "optimizer.cost_change is 2, expected a number from 0 to 1"),
        ({"curriculum": ("half",)}, "curriculum.0 is 'half', expected one of open, closed or a"),
        ({"curriculum": (1,)}, "curriculum.0 is 1"),
        ({"curriculum": ()}, "in a list such as"),
        ({"curriculum": "open"}, "in a list such as"),
    ],
)
def test_an_optimizer_refuses_nonsense_where_it_is_made(optimizer, values, says):
    with pytest.raises(UserError, match=says):
        optimizer(**values)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Adam(learning_rate=0.0), "optimizer.learning_rate is 0.0"),
        (lambda: Lbfgs(history_size=0), "optimizer.history_size is 0"),
        (lambda: Lbfgs(device="abacus"), "optimizer.device is 'abacus'"),
        (lambda: LevenbergMarquardt(bayesian="x"), "optimizer.bayesian is 'x'"),
        (lambda: LevenbergMarquardt(damping="none"), "'none', expected one of diagonal, identity"),
        (lambda: LevenbergMarquardt(gradient=-1), "optimizer.gradient is -1"),
        (lambda: LevenbergMarquardt(step=float("nan")), "optimizer.step is nan"),
        (lambda: LevenbergMarquardt(cost_deg2=-1), "optimizer.cost_deg2 is -1"),
    ],
)
def test_each_optimizer_refuses_its_own(make, says):
    with pytest.raises(UserError, match=says):
        make()


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"axis_weights": (0, 0, 0)}, r"axis_weights is \[0.0, 0.0, 0.0\], expected one above 0"),
        ({"axis_weights": (1, -1, 0)}, "axis_weights.1 is -1"),
        ({"axis_weights": (1, 1)}, "expected a list of 3, each a number"),
        ({"offset_free": "x"}, "offset_free is 'x'"),
        ({"washout_s": -1}, "washout_s is -1"),
        ({"rest_weight": float("inf")}, "rest_weight is inf"),
        ({"rest_leak_rad_s": 0.0}, "rest_leak_rad_s is 0.0, expected a number from 0.001 to"),
    ],
)
def test_an_objective_refuses_nonsense_where_it_is_made(values, says):
    with pytest.raises(UserError, match=says):
        Objective(**values)


@pytest.mark.parametrize("name", OPTIMIZERS)
def test_an_error_over_no_samples_is_refused(name):
    with pytest.raises(UserError, match=r"no sample .* counts; .*washout_s is 1000 s"):
        train(OPTIMIZERS[name], objective=Objective(washout_s=1000.0, rest_weight=0.0))
    with pytest.raises(UserError, match="no sample of the held-out sequences counts"):
        train(OPTIMIZERS[name], objective=Objective(washout_s=6.0))


def test_mean_errors_of_single_axes_are_not_taken_off():
    with pytest.raises(UserError, match=r"offset_free=true needs model\.coupled=true"):
        train(
            OPTIMIZERS["lbfgs"],
            design=NetworkDesign(coupled=False),
            objective=Objective(offset_free=True),
        )
    assert Objective().for_axes(coupled=True).offset_free is True
    assert Objective().for_axes(coupled=False).offset_free is False


def test_sources_of_different_rates_are_one_line():
    with pytest.raises(UserError, match="fast is sampled at 200 Hz, the network runs at 100 Hz"):
        train(Adam(restarts=1, iterations=1), sequences=[swing(), swing(rate_hz=200, name="fast")])


def test_an_untrained_network_has_zero_weights():
    model = NetworkDesign().untrained([swing()], offset_free=False)
    assert isinstance(model, Narx)
    assert isinstance(model.normalisation, Normalisation)
    assert not model.weights.detach().any()
