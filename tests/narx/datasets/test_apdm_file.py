"""HDF5 files of APDM in both public layouts: the sensor by its label, times from microseconds."""

import h5py
import numpy as np
import pytest

from narx.datasets.apdm_file import SUFFIXES
from narx.datasets.csv_recording import read_recording
from narx.errors import RecordingError
from narx.experiments.predictions.bulk import READABLE

LABELS = ("Right Upper Leg", "Left Lower Leg")


@pytest.fixture(scope="module")
def walk(device_walk):
    return device_walk(128.0, 6.0)


def _write(path, walk, layout, labels=LABELS):
    counts = (walk.time_s * 1e6).round().astype(np.uint64) + np.uint64(1_700_000_000_000_000)
    with h5py.File(path, "w") as file:
        if layout == 4:
            cases = [f"SI-00000{k}" for k in range(len(labels))]
            file.attrs["CaseIdList"] = [case.encode() for case in cases]
            file.attrs["MonitorLabelList"] = [f"{label}  ".encode() for label in labels]
        for k in range(len(labels)):
            group = file.create_group(cases[k] if layout == 4 else f"Sensors/{k + 100}")
            names = ("Gyroscope", "Accelerometer")
            if layout == 4:
                names = ("Calibrated/Gyroscopes", "Calibrated/Accelerometers")
            else:
                group.create_group("Configuration").attrs["Label 0"] = labels[k].encode()
            group["Time"] = counts
            group[names[0]] = walk.gyroscope_rad_s * (k + 1)
            group[names[1]] = walk.accelerometer_m_s2
    return path


@pytest.mark.parametrize("layout", [4, 5])
def test_the_sensor_of_a_segment_is_found_by_its_label(tmp_path, walk, layout):
    path = _write(tmp_path / "walk.h5", walk, layout)
    for factor, segment in ((1, "thigh_right"), (2, "shank_left")):
        read = read_recording(path, segment)
        np.testing.assert_allclose(read.time_s, walk.time_s, atol=1e-6)
        np.testing.assert_array_equal(read.gyroscope_rad_s, factor * walk.gyroscope_rad_s)
        np.testing.assert_array_equal(read.accelerometer_m_s2, walk.accelerometer_m_s2)
    assert "APDM: sensor 'Left Lower Leg'" in read.notes
    with pytest.raises(RecordingError, match="0 sensors for 'pelvis', expected one; labels: 'Rig"):
        read_recording(path, "pelvis")


def test_a_single_sensor_needs_no_label(tmp_path, walk):
    path = _write(tmp_path / "walk.h5", walk, 5, labels=("Lumbar",))
    assert read_recording(path).n_samples == len(walk.time_s)


def test_equal_values_that_take_no_space_need_memory(tmp_path):
    with h5py.File(tmp_path / "bomb.h5", "w") as file:
        group = file.create_group("Sensors/1")
        group.create_group("Configuration").attrs["Label 0"] = b"Lumbar"
        for name, shape in (("Time", 10**9), ("Gyroscope", (10**9, 3)), ("Accelerometer", (1, 3))):
            group.create_dataset(name, shape, np.float64, chunks=True)
    assert (tmp_path / "bomb.h5").stat().st_size < 2**20
    with pytest.raises(RecordingError, match="more than the limit of 4096 MiB"):
        read_recording(tmp_path / "bomb.h5")


def test_damage_is_one_line(tmp_path, walk):
    path = _write(tmp_path / "walk.h5", walk, 5)
    path.write_bytes(path.read_bytes()[:4000])
    with pytest.raises(RecordingError, match=r"walk\.h5: not a whole HDF5 file of APDM"):
        read_recording(path, "thigh_right")
    with h5py.File(path, "w") as file:
        file["a"] = [1.0]
    with pytest.raises(RecordingError, match=r"walk\.h5: not a whole HDF5 file of APDM"):
        read_recording(path, "thigh_right")


@pytest.mark.parametrize("kept", [0, 300])
def test_arrays_of_different_lengths_are_refused(tmp_path, walk, kept):
    path = _write(tmp_path / "walk.h5", walk, 5)
    with h5py.File(path, "r+") as file:
        for sensor in file["Sensors"].values():
            times = sensor["Time"][:kept]
            del sensor["Time"]
            sensor["Time"] = times
    with pytest.raises(RecordingError, match=rf"of one length expected, found {kept} of time_us"):
        read_recording(path, "thigh_right")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_of_a_folder_are_found_by_either_suffix(suffix):
    assert suffix in READABLE
