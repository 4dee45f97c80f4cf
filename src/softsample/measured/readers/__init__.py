"""Readers of the measured sets: one file each, `read` and what its source does not state."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from softsample.measured.measurement import Measurement
from softsample.measured.readers import brain, clot_pure_shear, clot_shear, cryogel, ecoflex


class Reader(NamedTuple):
    """How a set is read.

    Parameters
    ----------
    read : callable
        Records of a folder.
    unstated : tuple of str
        What is not stated with them, and what is done about it.
    cells : callable
        Load cell of each record that has siblings, by its name.
    evidence : callable
        What runs without a sample say of the machine, with units in the names.
    """

    read: Callable[[Path], list[Measurement]]
    unstated: tuple[str, ...]
    cells: Callable[[Path], dict[str, str]] = lambda folder: {}
    evidence: Callable[[Path], dict[str, float]] = lambda folder: {}


READERS: Mapping[str, Reader] = {
    "ecoflex-phantoms": Reader(ecoflex.read, ecoflex.UNSTATED, cells=ecoflex.load_cells),
    "cmc-cryogel": Reader(cryogel.read, cryogel.UNSTATED, evidence=cryogel.evidence),
    "blood-clot-myocardium": Reader(clot_shear.read, clot_shear.UNSTATED),
    "bloodclot-pureshear": Reader(clot_pure_shear.read, clot_pure_shear.UNSTATED),
    "brain-budday": Reader(brain.read, brain.UNSTATED),
}
