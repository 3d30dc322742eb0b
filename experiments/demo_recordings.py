"""Two recordings for a first try: thigh and shank of a simulated walker, as CSV files.

python -m experiments.demo_recordings output=demo
"""

from pathlib import Path

from omegaconf import DictConfig

from narx.datasets import SimulatedGait, write_recording
from narx.errors import UserError
from narx.experiments.command import command

SEGMENTS = ("thigh_right", "shank_right")


def _write(cfg: DictConfig) -> None:
    folder = Path(str(cfg.output))
    source = SimulatedGait(
        subjects=("S1",), conditions=("normal",), treadmill_duration_s=cfg.duration_s
    )
    trial = next(iter(source))
    for segment in SEGMENTS:
        try:
            write_recording(folder / f"{segment}.csv", trial.imus[segment])
        except OSError as error:
            raise UserError(f"output: '{folder}' cannot be written: {error.strerror}") from error
        print(folder / f"{segment}.csv")


main = command("demo_recordings", keeps_run=False)(_write)

if __name__ == "__main__":
    main()
