"""Train and evaluate NARX orientation models: 3D segment and knee angles from a gyroscope."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from narx.inference.predict import angles_from_gyroscope

__version__ = "0.1.0"
__all__ = ["__version__", "angles_from_gyroscope"]


def __getattr__(name: str) -> Any:
    # imported when it is first used: torch and numba take a second, `import narx` should not
    if name == "angles_from_gyroscope":
        from narx.inference.predict import angles_from_gyroscope

        return angles_from_gyroscope
    raise AttributeError(f"module 'narx' has no attribute '{name}'")
