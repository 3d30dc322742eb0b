"""Walks with errors that are known, for tables and figures."""

import importlib
import logging
import sys

import numpy as np
import pytest

from narx.evaluation.comparison import Evaluated, knee

_STRIDES_HZ = {"slow": 0.7, "normal": 0.9, "fast": 1.1, "abnormal": 0.8}


def _walk(segment, subject, condition, methods, seed, duration_s, bias_deg):
    # segments of one leg must not share their noise, or it would cancel in the knee
    generator = np.random.default_rng([seed, segment.startswith("thigh")])
    time_s = np.arange(0, duration_s, 0.02)
    phase = 2 * np.pi * _STRIDES_HZ.get(condition, 1.0) * time_s
    delay = 0.0 if segment.startswith("thigh") else 0.9
    reference = np.column_stack(
        [0.4 * np.sin(phase - delay), 0.08 * np.sin(phase + 1), 0.1 * np.sin(phase + 2)]
    )
    estimates = {}
    for method in methods:
        noise = np.deg2rad(generator.normal(0, 1.0, reference.shape))
        estimates[method] = reference - np.deg2rad(bias_deg) + noise
        if method == "gyro_integration":
            estimates[method] = estimates[method] + 0.005 * time_s[:, None]
        if method == "complementary_filter":
            estimates[method][:, 2] = np.nan
    return Evaluated(
        dataset="simulated_gait",
        subject=subject,
        condition=condition,
        trial="1",
        segment=segment,
        sampling_rate_hz=50.0,
        time_s=time_s,
        reference_rad=reference,
        estimates_rad=estimates,
        scored=time_s >= 2.0,
        std_rad={"narx": np.full(reference.shape, np.deg2rad(1.0))} if "narx" in methods else {},
    )


@pytest.fixture
def make_walk():
    def make(
        segment="thigh_right",
        subject="S1",
        condition="normal",
        methods=("narx", "complementary_filter", "pseudo_integrator"),
        seed=0,
        duration_s=20.0,
        bias_deg=0.0,
    ):
        return _walk(segment, subject, condition, methods, seed, duration_s, bias_deg)

    return make


@pytest.fixture
def make_study(make_walk):
    def study(
        subjects=("S1", "S2", "S3"), conditions=("slow", "normal", "fast"), knees=True, **options
    ):
        evaluated = []
        for i, subject in enumerate(subjects):
            for j, condition in enumerate(conditions):
                for side in ("right", "left"):
                    seed = 100 * i + 10 * j + (side == "left")
                    pair = [
                        make_walk(f"{part}_{side}", subject, condition, seed=seed, **options)
                        for part in ("thigh", "shank")
                    ]
                    evaluated += [*pair, knee(*pair)] if knees else pair
        return evaluated

    return study


@pytest.fixture
def run_command(monkeypatch, tmp_path, capsys):
    """Run `python -m experiments.<name> overrides...`; return status, output, error, directory."""

    def run(name, *overrides):
        directory = tmp_path / f"{name}_run"
        arguments = [f"experiments.{name}", *overrides]
        if "-m" not in overrides:
            arguments.append(f"hydra.run.dir={directory}")
        monkeypatch.setattr(sys, "argv", arguments)
        # Hydra would keep logging to the streams of the test before
        monkeypatch.setattr(logging, "raiseExceptions", False)
        capsys.readouterr()
        status = 0
        try:
            importlib.import_module(f"narx.experiments.{name}").main()
        except SystemExit as stop:
            status = stop.code
        printed = capsys.readouterr()
        return status, printed.out, printed.err, directory

    return run
