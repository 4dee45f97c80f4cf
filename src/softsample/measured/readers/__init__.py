"""Readers of the measured sets: one file each, `read` and what its source does not state."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from softsample.measured.measurement import Measurement
from softsample.measured.readers import brain, clot_pure_shear, clot_shear, cryogel, ecoflex


class Reader(NamedTuple):
    """How a set is read: its records below a folder, and what is not stated with them."""

    read: Callable[[Path], list[Measurement]]
    unstated: tuple[str, ...]


READERS: Mapping[str, Reader] = {
    "ecoflex-phantoms": Reader(ecoflex.read, ecoflex.UNSTATED),
    "cmc-cryogel": Reader(cryogel.read, cryogel.UNSTATED),
    "blood-clot-myocardium": Reader(clot_shear.read, clot_shear.UNSTATED),
    "bloodclot-pureshear": Reader(clot_pure_shear.read, clot_pure_shear.UNSTATED),
    "brain-budday": Reader(brain.read, brain.UNSTATED),
}
