"""How often a sensor that contradicts its optical reference is refused, on recorded trials.

python docs/contradictions.py DIR [source ...]

DIR holds `joint_1to3dof`, `broad` and `smartphone_pocket`. Every trial is read as it is, which must
pass, and with each fault made in what was read; a fault must be refused with the file's name, or
noted. Makes a table of docs/recordings.md.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
import pandas as pd

from narx.datasets import Broad, Joint1To3Dof, SmartphonePocket
from narx.datasets.base import TrialSource
from narx.datasets.tracked_sensor import AlignedSensors, RawSensor, align_sensors
from narx.errors import RecordingError
from narx.experiments.tables.table import Table

Sensors = Mapping[str, RawSensor]
SOURCES = (Joint1To3Dof, Broad, SmartphonePocket)


def _gyroscope(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Sensors], Sensors]:
    """Change the rates of the first sensor, and its bias with them."""

    def changed(sensors: Sensors) -> Sensors:
        (name, one), *_ = sensors.items()
        rates = change(one.gyroscope[:, 1:])
        first = replace(
            one,
            gyroscope=np.column_stack([one.gyroscope[:, 0], rates]),
            static_bias_rad_s=change(one.static_bias_rad_s[None])[0],
        )
        return {**sensors, name: first}

    return changed


def _reference(change: Callable[[np.ndarray, np.ndarray], None]) -> Callable[[Sensors], Sensors]:
    """Change time and orientation of the first sensor's reference in place."""

    def changed(sensors: Sensors) -> Sensors:
        (name, one), *_ = sensors.items()
        time, body = one.optical_time_s.copy(), one.body_wxyz.copy()
        change(time, body)
        return {**sensors, name: replace(one, optical_time_s=time, body_wxyz=body)}

    return changed


def _conjugated(time: np.ndarray, body: np.ndarray) -> None:
    body[:, 1:] *= -1.0


def _lost(time: np.ndarray, body: np.ndarray) -> None:
    body[len(body) // 2 :][:50] = 0.0


def _repeated(time: np.ndarray, body: np.ndarray) -> None:
    time[len(time) // 2] = time[len(time) // 2 - 1]


def _swapped(time: np.ndarray, body: np.ndarray) -> None:
    k = len(time) // 2
    time[[k, k + 1]] = time[[k + 1, k]]


def _sensors_exchanged(sensors: Sensors) -> Sensors:
    if len(sensors) < 2:
        return sensors
    (a, one), (b, other) = sensors.items()
    inertial = ("gyroscope", "accelerometer", "static_bias_rad_s")
    return {
        a: replace(one, **{name: getattr(other, name) for name in inertial}),
        b: replace(other, **{name: getattr(one, name) for name in inertial}),
    }


FAULTS: dict[str, Callable[[Sensors], Sensors]] = {
    "none": lambda sensors: sensors,
    "gyroscope: x and y exchanged": _gyroscope(lambda w: w[:, [1, 0, 2]]),
    "gyroscope: y and z exchanged": _gyroscope(lambda w: w[:, [0, 2, 1]]),
    "gyroscope: axes in the order yzx": _gyroscope(lambda w: w[:, [1, 2, 0]]),
    "gyroscope: y reversed": _gyroscope(lambda w: w * [1.0, -1.0, 1.0]),
    "gyroscope in deg/s": _gyroscope(np.degrees),
    "gyroscope rad/s taken for deg/s": _gyroscope(np.radians),
    "sensors of the joint exchanged": _sensors_exchanged,
    "quaternions conjugated": _reference(_conjugated),
    "50 lost poses written as zeros": _reference(_lost),
    "a stamp of the reference repeated": _reference(_repeated),
    "two stamps of the reference swapped": _reference(_swapped),
}


def verdicts(source: TrialSource) -> Iterator[tuple[str, str, str]]:
    """Yield trial, fault and verdict for every trial of a source."""
    module = sys.modules[type(source).__module__]
    for row in source.index().itertuples():
        names = str(row.subject), str(row.condition), str(row.trial)
        with mock.patch.object(module, "align_sensors", wraps=align_sensors) as called:
            source.load(*names)
        (sensors, *arguments), options = called.call_args

        def align(sensors: Sensors, arguments=arguments, options=options) -> AlignedSensors:
            return align_sensors(sensors, *arguments, **options)

        clean = align(sensors)
        for fault, change in FAULTS.items():
            changed = change(sensors)
            if changed is sensors and fault != "none":
                continue
            try:
                aligned = align(changed)
            except RecordingError as error:
                named = options["where"] in str(error)
                verdict = "refused" if named else f"refused without the file: {error}"
            else:
                more = [note for note in aligned.notes if "taken as missing" in note]
                verdict = "noted" if more else "passed"
                if verdict == "passed" and fault != "none":
                    (name, _), *_ = sensors.items()
                    verdict += _moved(clean, aligned, name)
            yield "/".join(names), fault, verdict


def _moved(clean: AlignedSensors, changed: AlignedSensors, name: str) -> str:
    """Say by how many degrees the reference in the sensor's frame has moved."""
    both = [a.reference[name].quaternion_wxyz for a in (clean, changed)]
    n = min(map(len, both))
    cosine = np.clip(np.abs((both[0][:n] * both[1][:n]).sum(axis=1)), 0.0, 1.0)
    return f" (reference moved by {np.degrees(2.0 * np.arccos(np.nanmedian(cosine))):.0f} deg)"


def main() -> None:
    """Print the table, and every fault that passed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("root", type=Path)
    parser.add_argument("sources", nargs="*", default=[source.name for source in SOURCES])
    given = parser.parse_args()
    counts: dict[str, Counter[str]] = {fault: Counter() for fault in FAULTS}
    for source in (one for one in SOURCES if one.name in given.sources):
        for trial, fault, verdict in verdicts(source(root=given.root / source.name)):
            counts[fault][verdict.partition(" ")[0]] += 1
            if verdict not in ("refused", "noted") and (fault != "none" or verdict != "passed"):
                print(f"{source.name}/{trial}: {fault}: {verdict}", flush=True)
    table = pd.DataFrame(
        [
            (fault, sum(found.values()), *(found[k] for k in ("refused", "noted", "passed")))
            for fault, found in counts.items()
        ],
        columns=["fault", "trials", "refused", "noted", "passed"],
    )
    print(Table("A sensor that contradicts its reference", table).to_markdown())


if __name__ == "__main__":
    main()
