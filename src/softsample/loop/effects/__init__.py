"""The library of effects: every module of this package but `base` holds one."""

import pkgutil
from importlib import import_module

from softsample.constitutive.material import Material
from softsample.loop.effects.base import Effect


def library(solid: Material | None = None) -> dict[str, Effect]:
    """All effects by name, in alphabetical order. Adding one means adding a file.

    Parameters
    ----------
    solid : Material, optional
        What the model is made of, for effects that depart from its constants; by default that of
        the study.
    """
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    modules = [import_module(f"{__name__}.{name}") for name in names if name != "base"]
    effects = [m.about(solid) if solid and hasattr(m, "about") else m.EFFECT for m in modules]
    return {effect.name: effect for effect in effects}
