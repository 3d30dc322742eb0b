"""Write a trained network for use where this package is not installed.

python -m experiments.export checkpoint=PATH format=torchscript output=narx.pt
"""

from omegaconf import DictConfig

from experiments.command import command
from narx.checkpoint import Checkpoint, load
from narx.errors import UserError
from narx.export import c, onnx, torch_export, torchscript
from narx.shipped import shipped_checkpoint

_WRITERS = {
    "torchscript": torchscript.write,
    "torch_export": torch_export.write,
    "onnx": onnx.write,
}
FORMATS = (*_WRITERS, "c")


def checkpoint_named(path: str | None) -> Checkpoint:
    """Load a checkpoint, or the network that ships with the package.

    Parameters
    ----------
    path : str, optional
        File from `experiments.train`; None for the shipped network.

    Returns
    -------
    Checkpoint
        The network and how to run it.

    Raises
    ------
    UserError
        If the file is not there or not a checkpoint.
    """
    return shipped_checkpoint() if path is None else load(path)


def _export(cfg: DictConfig) -> None:
    output = str(cfg.output)
    if cfg.format not in FORMATS:
        raise UserError(f"format is '{cfg.format}', expected one of {', '.join(FORMATS)}")
    checkpoint = checkpoint_named(cfg.checkpoint)
    try:
        if cfg.format == "c":
            c.write(checkpoint, output, cfg.precision)
        elif cfg.precision != "double":
            raise UserError(
                f"precision={cfg.precision} is for format=c; format={cfg.format} is float64, "
                "expected precision=double"
            )
        else:
            _WRITERS[cfg.format](checkpoint, output)
    except OSError as error:
        raise UserError(f"output: '{output}' cannot be written: {error.strerror}") from error
    print(f"{output}: {cfg.format}, {checkpoint.model.sampling_rate_hz:g} Hz")


main = command("export")(_export)

if __name__ == "__main__":
    main()
