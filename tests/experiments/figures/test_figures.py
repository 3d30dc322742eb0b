"""Figures show what is passed, tolerate missing values and leave global state unchanged."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from narx.errors import UserError
from narx.evaluation.agreement import repeated_limits_of_agreement
from narx.evaluation.uncertainty import calibration
from narx.experiments.figures.bland_altman import bland_altman
from narx.experiments.figures.calibration import calibration_figure
from narx.experiments.figures.canvas import save_figure
from narx.experiments.figures.drift import error_over_time, linear_drift
from narx.experiments.figures.histograms import peak_histograms, trial_histograms
from narx.experiments.figures.phases import phases
from narx.experiments.figures.spectrum import spectrum
from narx.experiments.figures.swing import swing_figure
from narx.experiments.figures.training import training_figure
from narx.experiments.figures.waveforms import first_and_last_minute, waveforms
from narx.experiments.method_labels import method_colour
from narx.experiments.peak_errors import swing, swing_results
from narx.experiments.tables.table import shown


def lines_of(panel, label):
    return [line for line in panel.get_lines() if line.get_label() == label]


def test_windows_of_the_first_and_the_last_minute(make_walk):
    (_, first), (name, last) = first_and_last_minute(make_walk(duration_s=300.0))
    assert (first.time_s[0], round(last.time_s[-1])) == (22.0, 280)
    assert name == "minute 5"
    windows = first_and_last_minute(make_walk(duration_s=15.0))
    assert [piece.time_s[0] for _, piece in windows] == [2.0, pytest.approx(4.98)]


def test_waveforms_show_reference_and_methods(make_walk):
    walk = make_walk()
    figure = waveforms([("walk", walk)])
    panel = figure.axes[0]
    (reference,) = lines_of(panel, "reference")
    np.testing.assert_allclose(reference.get_ydata(), np.rad2deg(walk.reference_rad[:, 0]))
    assert reference.get_linestyle() != "-"
    (narx,) = lines_of(panel, "NARX")
    np.testing.assert_allclose(narx.get_ydata(), np.rad2deg(walk.estimates_rad["narx"][:, 0]))
    assert narx.get_color() == method_colour("narx")


def test_waveforms_shade_two_standard_deviations(make_walk):
    walk = make_walk()
    std = np.full_like(walk.reference_rad, np.radians(1.5))
    walk = replace(walk, std_rad={"narx": std})
    panel = waveforms([("walk", walk)], ["narx", "pseudo_integrator"]).axes[0]
    (band,) = panel.collections
    edges = band.get_paths()[0].vertices
    middle = np.rad2deg(walk.estimates_rad["narx"][:, 0])
    assert edges[:, 1].max() == pytest.approx(middle.max() + 3.0)
    assert edges[:, 1].min() == pytest.approx(middle.min() - 3.0)


def test_a_method_that_ran_off_is_named_and_does_not_flatten_the_others(make_walk):
    walk = make_walk()
    walk.estimates_rad["pseudo_integrator"][:] += np.deg2rad(500)
    panel = waveforms([("walk", walk)]).axes[0]
    assert panel.get_ylim()[1] < 100
    assert any("PI at 500°" in text.get_text() for text in panel.texts)


def test_bland_altman_writes_the_limits_that_are_computed(make_study):
    knees = [e for e in make_study(bias_deg=2.0) if e.segment.startswith("knee")]
    figure = bland_altman(knees, rate_hz=50.0)
    assert len(figure.axes) == 9
    slow = [e for e in knees if e.condition == "slow"]
    errors = np.concatenate([e.error_deg("narx")[:, 0] for e in slow])
    subjects = np.repeat([e.subject for e in slow], [len(e.time_s) for e in slow])
    limits = repeated_limits_of_agreement(errors, subjects)
    written = [text.get_text() for text in figure.axes[0].texts]
    assert written == [shown(x, 1) for x in (limits.bias, limits.upper, limits.lower)]


def test_bland_altman_of_an_axis_that_is_not_observed(make_study):
    figure = bland_altman(make_study(conditions=("normal",)), "complementary_filter")
    assert figure.axes[2].texts[0].get_text() == "not observed"


def test_bland_altman_of_one_subject(make_walk):
    assert len(bland_altman([make_walk()]).axes) == 3


def test_spectrum_marks_the_components_with_most_power():
    time = np.arange(0, 40, 0.01)
    rate = 3 * np.sin(2 * np.pi * 0.9 * time) + np.sin(2 * np.pi * 1.8 * time)
    panel = spectrum(rate, 100.0).axes[0]
    assert panel.get_title().startswith("2 components hold 100.0 %")
    assert [text.get_text() for text in panel.texts] == ["1: 90.0 %", "2: 100.0 %"]
    with pytest.raises(UserError, match="no walking"):
        spectrum(np.zeros(4000), 100.0)


def test_histograms_count_every_peak_and_trial(make_study):
    study = make_study(knees=False, methods=("giof",))
    trials, peaks, _ = swing_results(e for e in study if e.segment.startswith("thigh"))
    counted = sum(
        p.get_path().vertices.shape[0] > 0 for p in trial_histograms(trials).axes[0].patches
    )
    assert counted == 2
    assert peak_histograms(peaks).axes[0].get_title() == "positive peaks"
    assert isinstance(peak_histograms(peaks[:0], ["giof"]), Figure)


def test_swing_figure_states_correlation_and_rmse(make_walk):
    angles = swing(make_walk(methods=("giof",)), "giof")
    rmse = np.sqrt(np.mean((angles.reference_deg - angles.estimate_deg) ** 2))
    assert f"RMSE = {rmse:.2f}°" in swing_figure(angles).axes[0].get_title()


def test_phases_mark_the_points_inside():
    time = np.arange(0, 2, 0.01)
    angle = 0.4 * np.sin(2 * np.pi * 0.9 * time)
    figure = phases(
        time, angle, np.gradient(angle, time), {"a": [0.3, 9.0], "b": 0.5}, {"heel_strike": [0.5]}
    )
    assert [text.get_text() for text in figure.axes[0].texts] == ["a", "b"]


def test_linear_drift_goes_through_the_errors_at_start_and_stop(make_walk):
    walk = make_walk(methods=("two_point", "gyro_integration"))
    error = np.rad2deg(walk.estimates_rad["gyro_integration"] - walk.reference_rad)
    figure = linear_drift([("thigh", walk)], 3.0, 15.0)
    (line,) = lines_of(figure.axes[1], "linear drift A to B")
    np.testing.assert_allclose(line.get_ydata(), error[[150, 750], 1])


def test_error_over_time(make_walk):
    walks = [make_walk(seed=k, duration_s=60.0, methods=("gyro_integration",)) for k in (0, 1)]
    figure = error_over_time(walks)
    (mean,) = lines_of(figure.axes[0], "Gyro integration")
    assert len(mean.get_xdata()) == 5 + 1
    assert mean.get_ydata()[-1] > 5 * mean.get_ydata()[0]


def test_training_and_calibration(make_walk):
    figure = training_figure({"cost": [3.0, 1.0, 0.0], "damping": [1.0, np.nan, 2.0]}, [[4.0, 2.0]])
    assert len(figure.axes) == 2
    staged = training_figure({"cost_deg2": [3.0, 1.0, 2.0, 1.5], "stage": [0.0, 0.0, 1.0, 1.0]})
    (panel,) = staged.axes
    assert panel.get_title() == "cost (deg²)"
    assert [line.get_xdata()[0] for line in panel.lines if line.get_linestyle() == ":"] == [2]
    walk = make_walk()
    found = calibration(np.deg2rad(walk.error_deg("narx")[:, 0]), walk.std_rad["narx"][:, 0])
    panel = calibration_figure([walk], rate_hz=50.0).axes[0]
    assert panel.get_legend().get_texts()[0].get_text() == (
        f"NARX\n68 % band: {100 * found.coverage_68:.0f} %, "
        f"95 % band: {100 * found.coverage_95:.0f} %"
    )


def test_saving_is_atomic_and_global_state_stays(make_walk, tmp_path):
    before = dict(mpl.rcParams)
    figure = waveforms([("walk", make_walk())])
    save_figure(figure, tmp_path / "figures" / "walk.png")
    assert dict(mpl.rcParams) == before
    assert [p.name for p in (tmp_path / "figures").iterdir()] == ["walk.png"]
    assert (tmp_path / "figures" / "walk.png").read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(ValueError, match="not supported"):
        save_figure(figure, tmp_path / "walk.docx")
    assert not (tmp_path / "walk.docx").exists()
