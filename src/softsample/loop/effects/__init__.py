"""The library of effects: every module of this package but `base` holds one."""

import pkgutil
from importlib import import_module

from softsample.loop.effects.base import Effect


def library() -> dict[str, Effect]:
    """All effects by name, in alphabetical order. Adding one means adding a file."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    modules = [import_module(f"{__name__}.{name}") for name in names if name != "base"]
    return {module.EFFECT.name: module.EFFECT for module in modules}
