"""JSON that every reader takes."""

import json
import math

import numpy as np

from narx.experiments.runs.record import write_json


def _refuse(constant):
    raise ValueError(constant)


def test_numbers_that_are_not_finite_are_null(tmp_path):
    path = tmp_path / "a.json"
    content = {"a": math.nan, "b": [1.5, -math.inf, (np.float64("nan"), 2)], "c": {"d": "NaN"}}
    write_json(content, path)
    read = json.loads(path.read_text(), parse_constant=_refuse)
    assert read == {"a": None, "b": [1.5, None, [None, 2]], "c": {"d": "NaN"}}
