"""The library of effects: every module of this package but `base` holds one."""

import pkgutil
from collections.abc import Sequence
from importlib import import_module
from types import ModuleType

from softsample.constitutive.material import Material
from softsample.loop.effects.base import MODES, Effect, Specimen


def library(
    solid: Material | None = None, tests: Sequence[Specimen] | None = None
) -> dict[str, Effect]:
    """All effects by name, in alphabetical order. Adding one means adding a file.

    A file has an `EFFECT`; besides, `about(solid)` if that depends on the model's constants, and
    `of_tests(tests)` if it depends on the records: None where these cannot show it.

    Parameters
    ----------
    solid : Material, optional
        What the model is made of, for effects that depart from its constants; by default that of
        the study.
    tests : sequence of Specimen, optional
        The records; without them effects that depend on these are as for a usual study.
    """
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    modules = [import_module(f"{__name__}.{name}") for name in names if name != "base"]
    effects = (_effect(module, solid, tests) for module in modules)
    kinds = MODES if tests is None else {test.kind for test in tests}
    return {effect.name: effect.of_kinds(kinds) for effect in effects if effect is not None}


def _effect(
    module: ModuleType, solid: Material | None, tests: Sequence[Specimen] | None
) -> Effect | None:
    found: Effect | None = module.EFFECT
    if solid is not None and hasattr(module, "about"):
        found = module.about(solid)
    elif tests is not None and hasattr(module, "of_tests"):
        found = module.of_tests(tests)
    return found
