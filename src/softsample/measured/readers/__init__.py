"""Readers of the measured sets: one file a set, which makes its samples and says what is known."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from softsample.measured.readers import (
    brain,
    clots,
    cryogel,
    ecoflex,
    muscle,
    mycelium,
    myocardium,
    pure_shear,
)
from softsample.measured.sample import Sample


class Reader(NamedTuple):
    """How samples are made of a set.

    Parameters
    ----------
    set : str
        Folder of the set.
    read : callable
        Samples of that folder.
    about : str
        What is known of the tests, and where it is said.
    unstated : tuple of str
        What is not stated with them, and what is done about it.
    """

    set: str
    read: Callable[[Path], list[Sample]]
    about: str
    unstated: tuple[str, ...]


def _reader(name: str, module: ModuleType, read: Callable[[Path], list[Sample]]) -> Reader:
    return Reader(name, read, module.ABOUT, module.UNSTATED)


READERS: Mapping[str, Reader] = {
    "ecoflex": _reader("ecoflex-phantoms", ecoflex, ecoflex.read),
    "cryogel": _reader("cmc-cryogel", cryogel, cryogel.read),
    "clots": _reader("blood-clot-myocardium", clots, clots.read),
    "myocardium": _reader("blood-clot-myocardium", myocardium, myocardium.read),
    "pure_shear": _reader("bloodclot-pureshear", pure_shear, pure_shear.read),
    "brain": _reader("brain-budday", brain, brain.read),
    "mycelium": _reader("fungi-steak", mycelium, mycelium.read),
    "muscle_rate": _reader("muscle-compression", muscle, muscle.read_rate),
    "muscle_magnitude": _reader("muscle-compression", muscle, muscle.read_magnitude),
}
"""By the key `reader` of config/measured.yaml."""
