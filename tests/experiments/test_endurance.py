"""What the measurement of long recordings compares: its files, and identical folders."""

import numpy as np
import pandas as pd
import pytest

from narx.errors import UserError
from narx.experiments.endurance import identical, write_session
from narx.recordings.trial import ImuRecording


def test_a_session_repeats_the_walk_on_one_clock(tmp_path):
    values = np.arange(600.0).reshape(200, 3)
    walk = {"thigh_right": ImuRecording("thigh_right", np.arange(200) / 100.0, values, -values)}
    options = write_session(walk, tmp_path, 5.0)
    assert options[0] == f"input={{thigh_right: {tmp_path / 'thigh_right'}.parquet}}"
    table = pd.read_parquet(tmp_path / "thigh_right.parquet")
    np.testing.assert_allclose(table.time_s, np.arange(500) / 100.0)
    np.testing.assert_array_equal(table.gyroscope_y_rad_s[400:], values[:100, 1])
    np.testing.assert_array_equal(table.accelerometer_z_m_s2[200:400], -values[:, 2])


def test_folders_are_compared_byte_by_byte(tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    for folder in (one, other):
        folder.mkdir()
        (folder / "0000_angles.csv").write_text("1")
    assert identical(one, other) == 1
    (other / "0000_angles.csv").write_text("2")
    with pytest.raises(UserError, match="differ"):
        identical(one, other)
    (other / "0000_angles.csv").unlink()
    with pytest.raises(UserError, match=r"has 1 files, .* 0"):
        identical(one, other)
