"""Reading a damaged recording gives plausible angles or a one-line error that names the file.

`NARX_MUTATIONS=10000 pytest tests/narx/datasets/test_mutations.py` tries as many, of which a fifth
are data sets of several files.
"""

import functools
import os
import shutil

import pytest
from beside import beside
from plausible import fault_of_file, fault_of_set

from narx.datasets import Broad, Joint1To3Dof, MotionBids, SmartphonePocket
from narx.datasets.study import Study
from narx.inference import pretrained

mutations = beside("narx/datasets/mutations.py")

N = int(os.environ.get("NARX_MUTATIONS", "100"))
_CHUNK = 50
_SETS = 5  # one of so many is a data set


@pytest.fixture(scope="module")
def method():
    return pretrained().method()


@pytest.fixture(scope="module")
def intact(tmp_path_factory):
    """A small data set of every source."""
    root = tmp_path_factory.mktemp("intact")
    for name in ("joint_1to3dof", "broad", "motion_bids", "study"):
        (root / name).mkdir()
    beside("narx/datasets/test_tracked_sensor.py").save_joint(
        root / "joint_1to3dof" / "data_2D_07.mat"
    )
    beside("narx/datasets/test_tracked_sensor.py").save_broad(
        root / "broad" / "99_made_up_motion.mat"
    )
    beside("narx/datasets/test_smartphone_pocket.py").write_walk(
        root / "smartphone_pocket", "Ada", "iPhone5"
    )
    beside("narx/datasets/test_motion_bids.py").write_bids(root / "motion_bids")
    beside("narx/datasets/test_study.py").write_study(root / "study")
    return {
        Broad: root / "broad",
        Joint1To3Dof: root / "joint_1to3dof",
        MotionBids: root / "motion_bids",
        SmartphonePocket: root / "smartphone_pocket",
        Study: root / "study",
    }


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, N // _SETS, _CHUNK))
def test_a_damaged_data_set_ends_with_a_trial_or_one_line(first, intact, tmp_path):
    wrong = []
    for seed in range(first, min(first + _CHUNK, N // _SETS)):
        source = list(intact)[seed % len(intact)]
        folder = tmp_path / str(seed)
        done = mutations.damaged_set(intact[source], folder, seed)
        fault = fault_of_set(functools.partial(source, root=folder))
        if fault is not None:
            wrong.append(f"seed {seed}, {source.__name__}, {done}: {fault}")
        shutil.rmtree(folder)
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, N - N // _SETS, _CHUNK))
def test_a_damaged_file_ends_with_a_result_or_one_line(first, method, tmp_path):
    wrong = []
    for seed in range(first, min(first + _CHUNK, N - N // _SETS)):
        path = mutations.damaged_file(tmp_path, seed)
        fault = fault_of_file(path, method)
        if fault is not None:
            wrong.append(f"seed {seed}, {path.name}: {fault}")
        path.unlink()
    assert not wrong, "\n".join(wrong)
