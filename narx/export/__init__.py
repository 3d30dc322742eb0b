"""A network for places where this package is not installed: TorchScript, torch.export, ONNX, C."""

from narx.export.identity import read_identity
from narx.export.write import write

__all__ = ["read_identity", "write"]
