"""Train and evaluate NARX orientation models: 3D segment and knee angles from a gyroscope."""

__version__ = "0.1.0"
