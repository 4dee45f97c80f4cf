"""Shear modulus of very soft tissue from an image and a force record, on real geometry."""

import sys
from importlib import import_module
from typing import Any

if sys.platform == "win32":
    raise ImportError("softsample runs on Linux and macOS; on Windows, install and run it in WSL")

__version__ = "0.1.0"

_PLACES = {
    "IdealShape": "softsample.shapes",
    "Material": "softsample.constitutive.material",
    "Term": "softsample.constitutive.material",
    "force_curve": "softsample.response.force",
    "read_mesh": "softsample.io",
    "check_study": "softsample.study.check",
    "run_study": "softsample.study.run",
}
"""Names for scripts, and where they are; loaded when they are asked for."""

__all__ = [*_PLACES, "__version__"]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'softsample' has no attribute {name!r}")
    return getattr(import_module(_PLACES[name]), name)
