"""Results that are asked for again and again with the same arrays."""

from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np

from softsample.arrays import Array

Method = Callable[..., Array]

LAST = 16
"""Results that are kept of each object: a fit moves one parameter of a few at a time."""


def remembered(method: Method) -> Method:
    """A method (of hashable values and arrays) that knows its last results; they are read only.

    Or a function of an object, which keeps them as it does those of its methods.
    """
    place = f"_last_{method.__name__}"

    @wraps(method)
    def asked(self: Any, *given: Any) -> Array:
        key = tuple([x.tobytes() if isinstance(x, np.ndarray) else x for x in given])
        known: dict[Any, Array] = self.__dict__.setdefault(place, {})
        if key not in known:
            if len(known) >= LAST:
                known.pop(next(iter(known)))
            known[key] = method(self, *given)
            known[key].flags.writeable = False
        return known[key]

    return asked
