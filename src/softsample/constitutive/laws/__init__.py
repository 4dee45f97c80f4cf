"""The dictionary of elastic laws: every module of this package holds one, its `LAW`."""

import pkgutil
from importlib import import_module

from softsample.constitutive.law import Law


def _found() -> dict[str, Law]:
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    laws = [import_module(f"{__name__}.{name}").LAW for name in names]
    return {law.name: law for law in laws}


LAWS: dict[str, Law] = _found()
"""All laws by name, in alphabetical order of their files. Adding one means adding a file."""
