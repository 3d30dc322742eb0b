"""What the fuzzer runs: one target for each kind of file that is read, for configurations and runs.

A target takes bytes, reads them and describes what is wrong with the outcome, or returns None.
The bytes are the file itself, or a description of files (`fuzz_documents`).
"""

import functools
import gzip
import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import fuzz_documents as documents
import numpy as np
import scipy.io
import torch
from beside import beside
from hydra import compose, initialize_config_module
from hydra.errors import HydraException
from omegaconf.errors import OmegaConfBaseException
from plausible import angles_of, fault, fault_of_file, fault_of_set

from narx.datasets import Broad, Joint1To3Dof, MotionBids, NeuraSample, SmartphonePocket
from narx.datasets.calendar_times import seconds_of
from narx.datasets.device_layouts import read_layout
from narx.datasets.study import Study
from narx.errors import UserError
from narx.experiments.compare.__main__ import compare
from narx.experiments.configuration import checked_configuration, composition_mistake
from narx.experiments.configuration.schemas import SCHEMAS
from narx.experiments.overrides import readable
from narx.inference import checkpoint as checkpoints
from narx.inference import pretrained
from narx.inference.checkpoint_archive import digest, to_bytes
from narx.inference.narx_method import NarxMethod
from narx.inference.stream import OrientationStream

TESTS = Path(__file__).parent
Target = Callable[[bytes, Path], str | None]
# files that a data set of several files may hold in all
_MOST_FILES = 12


@functools.cache
def _method() -> NarxMethod:
    return pretrained().method()


def _built(build: Callable[[Any], bytes], document: Any) -> bytes | None:
    """The file that is described; None if the description means nothing."""
    try:
        return build(document)
    except Exception:
        return None


def _recording(suffix: str, build: Callable[[Any], bytes]) -> Target:
    """Target of a recording in one file."""

    def run(data: bytes, folder: Path) -> str | None:
        document = documents.document_in(data)
        content = data if document is None else _built(build, document)
        if content is None:
            return None
        packed = document is not None and bool(document.get("gzip"))
        path = folder / f"walk{'.csv.gz' if packed else suffix}"
        path.write_bytes(gzip.compress(content) if packed else content)
        return fault_of_file(path, _method())

    return run


def _times(data: bytes, folder: Path) -> str | None:
    """Target of dates and times: one a line."""
    lines = data.decode("utf-8", errors="replace").splitlines()[:200]

    def read() -> list[np.ndarray]:
        seconds = seconds_of(lines)
        assert seconds.shape == (len(lines),)
        assert not np.isinf(seconds).any()
        return []

    return fault(read) if lines else None


def _device(data: bytes, folder: Path) -> str | None:
    """Target of the description of a device, with a recording of it."""
    document = documents.document_in(data)
    if document is None or not _written(document.get("files"), folder):
        return None
    layout, path = folder / "device.yaml", folder / "walk.csv"
    if not (layout.is_file() and path.is_file()):
        return None
    return fault(lambda: [angles_of(path, _method(), read_layout(layout))])


def _data_set(source: Callable[..., Any]) -> Target:
    """Target of a data set of several files."""

    def run(data: bytes, folder: Path) -> str | None:
        document = documents.document_in(data)
        if document is None or not _written(document.get("files"), folder):
            return None
        return fault_of_set(lambda: source(root=folder))

    return run


def _written(files: Any, folder: Path) -> bool:
    """Write the files of a data set; False if they are not files below the folder."""
    if not isinstance(files, Mapping) or len(files) > _MOST_FILES:
        return False
    for name, described in files.items():
        content = _built(documents.content_of, described)
        parts = Path(name).parts
        if content is None or "\0" in name or ".." in parts or Path(name).is_absolute():
            return False
        try:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
        except (OSError, UnicodeError):  # a name that is too long, or that of a folder
            return False
    return True


@functools.cache
def _published() -> dict[str, dict[str, Any]]:
    """A small recording in the format of each published data set of `.mat` files."""
    tracked = beside("narx/datasets/test_tracked_sensor.py")
    saved: dict[str, Any] = {}

    def keep(path: str, variables: Mapping[str, Any], **options: Any) -> None:
        saved.update(variables)

    found = {}
    original, scipy.io.savemat = scipy.io.savemat, keep
    try:
        for name in ("joint", "broad"):
            saved.clear()
            getattr(tracked, f"save_{name}")("")
            found[name] = dict(saved.get("data", saved))
    finally:
        scipy.io.savemat = original
    return found | {"neura": beside("narx/datasets/neura_walk.py").points_mm()}


def _published_set(data: bytes, folder: Path) -> str | None:
    """Target of a published data set: its recording with changed arrays."""
    document = documents.document_in(data)
    sources = {"joint": Joint1To3Dof, "broad": Broad, "neura": NeuraSample}
    if document is None or str(document.get("source")) not in sources:
        return None
    name, changes = str(document["source"]), document.get("changes")
    try:
        variables = dict(_published()[name])
        for key, change in changes.items():
            variables[key] = _changed(variables.get(key, np.zeros((100, 3))), change)
        kept = {key: value for key, value in variables.items() if value is not None}
        if name == "neura":
            beside("narx/datasets/neura_walk.py").write_neura(folder, kept)
        elif name == "joint":
            scipy.io.savemat(folder / "data_2D_07.mat", {"data": kept})
        else:
            scipy.io.savemat(folder / "99_made_up_motion.mat", kept)
    except Exception:
        return None
    return fault_of_set(lambda: sources[name](root=folder))


def _changed(array: Any, change: Mapping[str, Any] | None) -> Any:
    if change is None:
        return None
    array = np.array(array, dtype=float)
    begin, end = change.get("rows", (0, len(array) if array.ndim else 0))
    array = array[begin:end] if array.ndim else array
    with np.errstate(all="ignore"):
        array = array * change.get("times", 1.0) + change.get("plus", 0.0)
        if "shape" in change:
            array = np.resize(array, change["shape"])
        for place, value in (change.get("put") or {}).items():
            array.flat[int(place)] = np.nan if value is None else value
        return array.astype(change.get("type", "float64"))


@functools.cache
def _phone_walk(folder: Path) -> Path:
    beside("narx/datasets/test_smartphone_pocket.py").write_walk(folder, "Ada", "iPhone5")
    return folder


def _phone_set(data: bytes, folder: Path) -> str | None:
    """Target of the smartphones' data set: a walk with some text files replaced."""
    document = documents.document_in(data)
    if document is None:
        return None
    whole = _phone_walk(folder.with_name("phone walk"))
    shutil.copytree(whole, folder, dirs_exist_ok=True)
    if not _written(document.get("files"), folder):
        return None
    return fault_of_set(lambda: SmartphonePocket(root=folder))


@functools.cache
def _runs(folder: Path) -> Path:
    make_run = beside("experiments/compare/test_compare.py").make_run
    shutil.rmtree(folder, ignore_errors=True)  # of fuzzing in this folder before
    for seed in (0, 1):
        make_run(folder / str(seed), 3, seed, 1.5 + seed)
    return folder


def _compared(data: bytes, folder: Path) -> str | None:
    """Target of what runs leave for narx-compare: two runs with some files replaced."""
    document = documents.document_in(data)
    if document is None:
        return None
    shutil.copytree(_runs(folder.with_name("runs")), folder, dirs_exist_ok=True)
    if not _written(document.get("files"), folder):
        return None

    def run() -> list[np.ndarray]:
        assert compare([folder], None, None, folder)
        return []

    return fault(run)


def _checkpoint(data: bytes, folder: Path) -> str | None:
    """Target of a trained network: its file, or its fields with a valid checksum."""
    document = documents.document_in(data)
    content = data if document is None else _built(_sealed, document)
    if content is None:
        return None
    path = folder / "network.pt"
    path.write_bytes(content)
    samples = np.random.default_rng(2).normal(size=(20, 6))

    def run() -> list[np.ndarray]:
        network = checkpoints.load(path)
        stream = OrientationStream(network.method(), network.model.sampling_rate_hz)
        angles = stream.update_block(samples).angles_rad
        assert angles.shape == (20, 3)
        # any weights are a network, so its angles may have any size
        return []

    return fault(run, path.name)


def _sealed(document: dict[str, Any]) -> bytes:
    content = dict(document)
    if isinstance(content.get("weights"), list):
        content["weights"] = torch.tensor(content["weights"], dtype=torch.float64)
    if content.get("format") is not None and "sha256" not in content:
        content["sha256"] = digest(content)
    return to_bytes(content)


def _configuration(data: bytes, folder: Path) -> str | None:
    """Target of a command's overrides, which are composed and checked."""
    document = documents.document_in(data) or {}
    command, given = str(document.get("command")), document.get("overrides")
    if command not in SCHEMAS or not isinstance(given, list) or len(given) > 6:
        return None
    if not all(isinstance(one, str) and one and "_target_" not in one for one in given):
        return None
    overrides = readable(given)

    def check() -> list[np.ndarray]:
        try:
            with initialize_config_module("narx.configs", version_base="1.3"):
                composed = compose(command, overrides=overrides)
        except (HydraException, OmegaConfBaseException, RecursionError, ValueError) as error:
            raise UserError(composition_mistake(error, command, overrides)) from None
        checked_configuration(composed, command)
        return []

    return fault(check)


_BUILDERS: dict[str, Callable[[Any], bytes]] = {
    "text": documents.text,
    "parquet": documents.parquet,
    "mat": documents.mat,
    "apdm": documents.hdf5,
    "bundle": documents.archive,
    "checkpoint": _sealed,
}
_SUFFIXES = {
    "text": ".csv", "parquet": ".parquet", "mat": ".mat", "apdm": ".h5", "bundle": ".zip",
}  # fmt: skip
TARGETS: dict[str, Target] = {
    **{name: _recording(suffix, _BUILDERS[name]) for name, suffix in _SUFFIXES.items()},
    "times": _times,
    "device": _device,
    "study": _data_set(Study),
    "motion_bids": _data_set(MotionBids),
    "published": _published_set,
    "smartphone_pocket": _phone_set,
    "runs": _compared,
    "checkpoint": _checkpoint,
    "configuration": _configuration,
}


def outcome(target: str, data: bytes, folder: Path) -> str | None:
    """Run a target on an input.

    Parameters
    ----------
    target : str
        One of `TARGETS`.
    data : bytes
        The input.
    folder : pathlib.Path
        For its files; emptied before.

    Returns
    -------
    str or None
        What is wrong, in one line; None if nothing is.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    wrong = TARGETS[target](data, folder)
    return None if wrong is None else re.sub(r"\s+", " ", wrong.replace(str(folder), "..."))


def whole_files(target: str) -> dict[str, bytes]:
    """Build the files that the corpus of a target describes, from which bytes are changed.

    Parameters
    ----------
    target : str
        One of `TARGETS`.

    Returns
    -------
    dict of str to bytes
        Name to content; empty for a target whose inputs are only descriptions.
    """
    build = _BUILDERS.get(target)
    found = {}
    for path in sorted((TESTS / "corpus" / target).glob("*")) if build else ():
        document = documents.document_in(path.read_bytes())
        content = None if document is None else _built(build, _shorter(document))
        if content is not None:
            found[f"whole-{path.stem}"] = content
    return found


def _shorter(document: dict[str, Any]) -> dict[str, Any]:
    """The same with few rows, since a fuzzer does better with small inputs."""
    rows = document.get("rows")
    return {**document, "rows": min(rows, 40)} if isinstance(rows, int) else document
