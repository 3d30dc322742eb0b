"""Write a trained network for use where this package is not installed.

python -m experiments.export checkpoint=PATH format=torchscript output=narx.pt
"""

from pathlib import Path

from omegaconf import DictConfig

from narx.experiments.command import command
from narx.experiments.free_output import check_free
from narx.export import write
from narx.inference.pretrained import load_or_pretrained


def _export(cfg: DictConfig) -> None:
    output = str(cfg.output)
    checkpoint = load_or_pretrained(cfg.checkpoint)
    if cfg.checkpoint is not None:
        check_free([Path(output)], [Path(str(cfg.checkpoint))], "checkpoint")
    about = write(checkpoint, output, cfg.format, cfg.precision, cfg.verify)
    verified = about["verification"]
    print(
        f"{output}: {about['format']}, {about['precision']}, {about['sampling_rate_hz']:g} Hz, "
        f"checkpoint {about['checkpoint_sha256'][:12]}, "
        + (
            f"at most {verified['largest_difference_rad']:.1e} rad from the package"
            if verified
            else "not verified"
        )
    )


main = command("export", keeps_run=False)(_export)

if __name__ == "__main__":
    main()
