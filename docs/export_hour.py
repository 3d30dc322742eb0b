"""Run exports over an hour of walking and print how far they are from the package.

python docs/export_hour.py [--minutes M] [--only FORMAT:PRECISION ...]

The shipped network; three people walk at 100 Hz with rests and turns. Of all 2 % of the samples are
lost as NaN; of the second and third also 1 % of the packets, each of one to ten samples, so that
only the intervals show it; the sampling times of the third scatter by 30 % of an interval. Graphs
are given blocks of random size. Makes the table of docs/export.md, a row as soon as it is measured.
"""

import argparse
from itertools import product

import numpy as np

from narx.export import verification
from narx.export.write import build, runner
from narx.inference.pretrained import pretrained
from narx.inference.stream import OrientationStream
from narx.types import FloatArray

RATE_HZ, LOST, LOST_PACKETS = 100.0, 0.02, 0.01
LOSSES = ("samples", "samples and packets", "samples and packets, jitter")
DTYPES: dict[str, type] = {"double": np.float64, "float": np.float32}
FORMATS = ("c", "torchscript", "onnx", "torch_export")


def walk(minutes: float, seed: int, lost: str) -> tuple[FloatArray, FloatArray]:
    """Make walks of 20 to 180 s, one after another, as they are received.

    Parameters
    ----------
    minutes : float
        Duration of the samples received, min.
    seed : int
        Of the random numbers.
    lost : str
        One of `LOSSES`.

    Returns
    -------
    rates : ndarray, shape (N, 3)
        rad/s; NaN where lost.
    interval_s : ndarray, shape (N,)
        Times since the samples before, s.
    """
    rng, n_samples = np.random.default_rng(seed), round(minutes * 60.0 * RATE_HZ)
    n_sent = round(1.1 * n_samples) + 20  # some 5 % are lost in packets
    pieces: list[FloatArray] = []
    time_s = np.arange(n_sent) / RATE_HZ
    if "jitter" in lost:
        time_s += rng.uniform(-0.15, 0.15, n_sent) / RATE_HZ
    while sum(map(len, pieces)) < n_sent:
        begin = sum(map(len, pieces))
        one_s = time_s[begin : begin + round(rng.uniform(20.0, 180.0) * RATE_HZ)]
        pieces.append(verification.walk(one_s - begin / RATE_HZ)[:, :3] * rng.uniform(0.7, 1.2))
    rates = np.concatenate(pieces) + 0.02 * rng.normal(size=(n_sent, 3))
    rates[rng.random(n_sent) < LOST] = np.nan
    received = np.ones(n_sent, bool)
    if "packets" in lost:
        for begin in np.flatnonzero(rng.random(n_sent) < LOST_PACKETS):
            received[begin : begin + rng.integers(1, 11)] = False
    received[0] = True
    interval_s = np.diff(time_s[received], prepend=-1.0 / RATE_HZ)
    return rates[received][:n_samples], interval_s[:n_samples]


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
    walks = [walk(options.minutes, seed, lost) for seed, lost in enumerate(LOSSES)]
    rates, interval_s = (np.stack(part) for part in zip(*walks, strict=True))
    print("| format | precision | minutes | lost | tilt, rad | heading, rad |")
    print("|---|---|---|---|---|---|")
    for name in options.only:
        export_format, precision = name.split(":")
        largest = differences(export_format, precision, rates, interval_s)
        for lost, row in zip(LOSSES, largest, strict=True):
            print(
                f"| `{export_format}` | {precision} | {options.minutes:g} | {lost} "
                f"| {row[:2].max():.1e} | {row[2]:.1e} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
