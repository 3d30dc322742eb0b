"""Orientation methods to compare a network with, one a file, behind one interface.

Nothing is imported before it is asked for, so a method whose library is missing troubles no
other.
"""

import importlib
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from narx.errors import UserError

if TYPE_CHECKING:
    from narx.method import OrientationMethod

METHODS: Mapping[str, str] = MappingProxyType(
    {
        "gyro_integration": "narx.baselines.gyro_integration.GyroIntegration",
        "pseudo_integrator": "narx.baselines.pseudo_integrator.PseudoIntegrator",
        "complementary_filter": "narx.baselines.complementary_filter.ComplementaryFilter",
        "giof": "narx.baselines.giof.Giof",
        "two_point": "narx.baselines.two_point.TwoPoint",
        "vqf": "narx.baselines.vqf.Vqf",
        "madgwick": "narx.baselines.madgwick.Madgwick",
        "mahony": "narx.baselines.mahony.Mahony",
    }
)


def method_class(name: str) -> type["OrientationMethod"]:
    """Look up the class of a method by its name.

    Parameters
    ----------
    name : str
        Key of `METHODS`.

    Returns
    -------
    type
        Subclass of `narx.method.OrientationMethod`.

    Raises
    ------
    UserError
        If no method has that name.
    """
    if name not in METHODS:
        raise UserError(f"no method is named '{name}', expected one of {', '.join(METHODS)}")
    module, _, attribute = METHODS[name].rpartition(".")
    return getattr(importlib.import_module(module), attribute)


def make_method(name: str, **parameters: Any) -> "OrientationMethod":
    """Make a method by its name.

    Parameters
    ----------
    name : str
        Key of `METHODS`.
    **parameters
        Parameters of its class.

    Returns
    -------
    OrientationMethod
        Ready to estimate.

    Raises
    ------
    UserError
        If no method has that name, or a parameter is wrong.
    MethodNotApplicableError
        If it needs a library that is not installed.
    """
    return method_class(name)(**parameters)
