"""Write a trained network for use where this package is not installed.

python -m experiments.export checkpoint=PATH format=torchscript output=narx.pt
"""

from omegaconf import DictConfig

from narx.errors import UserError
from narx.experiments.command import command
from narx.export import c, onnx, torch_export, torchscript
from narx.inference.pretrained import load_or_pretrained

_WRITERS = {
    "torchscript": torchscript.write,
    "torch_export": torch_export.write,
    "onnx": onnx.write,
}
FORMATS = (*_WRITERS, "c")


def _export(cfg: DictConfig) -> None:
    output = str(cfg.output)
    if cfg.format not in FORMATS:
        raise UserError(f"format is '{cfg.format}', expected one of {', '.join(FORMATS)}")
    checkpoint = load_or_pretrained(cfg.checkpoint)
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


main = command("export", keeps_run=False)(_export)

if __name__ == "__main__":
    main()
