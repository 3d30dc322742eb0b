"""Export of a network for use without this package: TorchScript, torch.export, ONNX, C."""

from narx.export.identity import read_identity
from narx.export.write import write

__all__ = ["read_identity", "write"]
