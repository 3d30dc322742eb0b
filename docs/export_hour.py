"""Run exports over an hour of walking and print how far they are from the package.

python docs/export_hour.py [--minutes M] [--only FORMAT:PRECISION ...]

The shipped network; two people walk at 100 Hz with rests and turns. Of one 2 % of the samples are
lost as NaN; of the other 1 % of the packets, each of one to ten samples, as well, so that only the
intervals show it. Makes the table of docs/export.md; rows appear as they are measured.
"""

import argparse
from itertools import product

import numpy as np

from narx.export import verification
from narx.export.write import build, runner
from narx.inference.pretrained import pretrained
from narx.inference.stream import OrientationStream
from narx.types import FloatArray

RATE_HZ, LOST = 100.0, 0.02
DTYPES: dict[str, type] = {"double": np.float64, "float": np.float32}
FORMATS = ("c", "torchscript", "onnx", "torch_export")


def walk(minutes: float, seed: int, packets: bool) -> tuple[FloatArray, FloatArray]:
    """Make rates (N, 3) of walks of 20 to 180 s, rad/s, and the times between samples (N,), s."""
    rng, n_samples = np.random.default_rng(seed), round(minutes * 60.0 * RATE_HZ)
    pieces: list[FloatArray] = []
    while sum(map(len, pieces)) < n_samples:
        time_s = np.arange(round(rng.uniform(20.0, 180.0) * RATE_HZ)) / RATE_HZ
        pieces.append(verification.walk(time_s)[:, :3] * rng.uniform(0.7, 1.2))
    rates = np.concatenate(pieces)[:n_samples] + 0.02 * rng.normal(size=(n_samples, 3))
    rates[rng.random(n_samples) < LOST] = np.nan
    interval_s = np.full(n_samples, 1.0 / RATE_HZ)
    if packets:
        lost = rng.random(n_samples) < 0.01
        interval_s *= np.where(lost, rng.integers(2, 12, n_samples), 1)
    return rates, interval_s


def differences(
    export_format: str, precision: str, rates: FloatArray, interval_s: FloatArray
) -> FloatArray:
    """Compare an export with the package's stream.

    Parameters
    ----------
    export_format, precision : str
        As for `narx.export.write`.
    rates : ndarray, shape (B, N, 3)
        rad/s; NaN where lost.
    interval_s : ndarray, shape (B, N)
        Times since the samples before, s.

    Returns
    -------
    ndarray, shape (B, 3)
        Largest difference of each angle, rad.
    """
    checkpoint = pretrained()
    # both are given the same numbers
    rates, interval_s = (part.astype(DTYPES[precision]) for part in (rates, interval_s))
    stream = OrientationStream(checkpoint.method(), RATE_HZ, n_sensors=len(rates))
    times_s = np.cumsum(interval_s.astype(np.float64), axis=1)
    expected = stream.update_block(rates, times_s).angles_rad
    run = runner(checkpoint, export_format, build(checkpoint, export_format, precision))
    found = run(rates, interval_s, None)
    if not np.array_equal(np.isnan(found), np.isnan(expected)):
        raise SystemExit(f"{export_format}, {precision}: other samples are missing")
    return np.asarray(np.nanmax(np.abs(found - expected), axis=1))


def main() -> None:
    """Print a row for every format and precision."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0)
    every = [f"{name}:{precision}" for name, precision in product(FORMATS, ("float", "double"))]
    parser.add_argument("--only", nargs="+", choices=every, default=every)
    options = parser.parse_args()
    walks = [walk(options.minutes, seed, packets) for seed, packets in ((5, False), (6, True))]
    rates, interval_s = (np.stack(part) for part in zip(*walks, strict=True))
    print("| format | precision | minutes | lost | tilt, rad | heading, rad |")
    print("|---|---|---|---|---|---|")
    for name in options.only:
        export_format, precision = name.split(":")
        largest = differences(export_format, precision, rates, interval_s)
        for lost, row in zip(("samples", "samples and packets"), largest, strict=True):
            print(
                f"| `{export_format}` | {precision} | {options.minutes:g} | {lost} "
                f"| {row[:2].max():.1e} | {row[2]:.1e} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
