"""Which experiments are made: effects, nulls, strangers, pairs; each drawn from its own seed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from softsample.blindlab.bodies import Body
from softsample.blindlab.faults import EFFECTS, KINDS, SCALES, STRANGERS, Fault
from softsample.blindlab.records import FAMILIES, MU_PA, Floor, Record, make_records, of_misfits

GROUPS: dict[str, tuple[str, ...]] = {
    "ratio of shear to axial": (
        "poisson_ratio", "anisotropy", "residual_precompression", "boundary_shift",
        "machine_compliance",
    ),
    "ratio of compression to tension": (
        "tension_compression_asymmetry", "platen_slip", "partial_bond",
    ),
    "onset of contact": ("late_contact", "platen_tilt", "adhesion", "displacement_zero"),
    "time": (
        "viscoelastic_relaxation", "poroelastic_drainage", "dehydration", "force_drift",
        "mains_pickup",
    ),
    "unloading": ("mullins_softening", "backlash", "bond_peel"),
    "constant": ("force_offset", "self_weight"),
    "shape of the curve": ("ogden_exponents",),
    "shift in time": ("channel_lag",),
}  # fmt: skip
"""Effects that are easily taken for each other; pairs come from different groups."""


@dataclass(frozen=True)
class Extent:
    """How much is done; mirrors an entry of config `blind: extents:`.

    Parameters
    ----------
    designs : sequence of str
        Keys of `records.DESIGNS`.
    sizes : sequence of float
        Multiples of the nominal size.
    floors_percent : sequence of float
        Unexplained smooth errors of the model [% of peak].
    seeds : int
        Experiments of each effect, design, size and floor.
    nulls, pairs : int
        Experiments without effect, and with two, for each design and floor.
    first_seed : int
        Seeds below are for development.
    family : str
        Key of `records.FAMILIES`: how the error of the model goes with the travel.
    scale_percent : float
        Standard deviation of the scale of each test [%].
    told : bool
        Whether the diagnosis knows the size of these errors; if not, it has its usual settings.
    """

    designs: Sequence[str] = ("B",)
    sizes: Sequence[float] = (1.0,)
    floors_percent: Sequence[float] = (0.0, 1.0)
    seeds: int = 60
    nulls: int = 400
    pairs: int = 60
    first_seed: int = 70000
    family: str = "gaussian"
    scale_percent: float = 0.0
    told: bool = True

    def floor(self, experiment: "Experiment", misfits: pd.DataFrame | None = None) -> Floor:
        """Errors of the model in an experiment, drawn from misfits of measured records if given."""
        draw = FAMILIES[self.family] if misfits is None else of_misfits(misfits)
        return Floor(experiment.floor_percent, draw, self.scale_percent)


@dataclass(frozen=True)
class Experiment:
    """One animal in the laboratory.

    Parameters
    ----------
    kind : str
        `null`, `effect`, `scale`, `stranger` or `pair`.
    names : tuple of str
        What is wrong.
    design, size, floor_percent, seed
        See `Extent`.
    """

    kind: str
    names: tuple[str, ...]
    design: str
    size: float
    floor_percent: float
    seed: int

    @property
    def random(self) -> np.random.Generator:
        """Its random numbers; the same for every call."""
        text = f"{self.names} {self.design} {self.size} {self.floor_percent}"
        return np.random.default_rng([self.seed, *text.encode()])

    def body(self, benches: "Benches") -> Body:
        """Which sample it is made with."""
        choice = benches.bodies(any(KINDS[name].imperfect for name in self.names))
        return choice[self.seed % len(choice)]

    def prepared(self, body: Body) -> tuple[float, list[Fault], np.random.Generator]:
        """Modulus [Pa], faults, and the random numbers that are left."""
        random = self.random
        mu = float(random.uniform(*MU_PA))
        return mu, [KINDS[name].make(random, body, self.size) for name in self.names], random

    def records(self, body: Body, curves: pd.DataFrame, floor: Floor) -> list[Record]:
        """The records, without a word on what is wrong."""
        mu, faults, random = self.prepared(body)
        return make_records(body, curves, faults, mu, self.design, floor, self.size, random)

    def planted(self, body: Body) -> dict[str, Any]:
        """What only the score may see."""
        mu, faults, _ = self.prepared(body)
        return {
            "kind": self.kind,
            "names": list(self.names),
            "design": self.design,
            "size": self.size,
            "floor_percent": self.floor_percent,
            "seed": self.seed,
            "body": body.name,
            "mu_pa": mu,
            "sizes": {fault.name: dict(fault.sizes) for fault in faults},
        }


@dataclass(frozen=True)
class Benches:
    """The samples of the laboratory; mirrors config `blind: bodies:`.

    Parameters
    ----------
    cuboids, shapes : int
        How many perfect and imperfect ones.
    first : int
        Number of the first of each.
    """

    cuboids: int = 8
    shapes: int = 4
    first: int = 700

    def bodies(self, imperfect: bool) -> list[Body]:
        """Perfect or imperfect bodies."""
        count = self.shapes if imperfect else self.cuboids
        return [Body.draw(self.first + k, imperfect) for k in range(count)]


def plan(extent: Extent) -> list[Experiment]:
    """All experiments of an extent, in an order that tells nothing."""
    found = [
        Experiment(kind, names, design, size, floor, seed)
        for design in extent.designs
        for floor in extent.floors_percent
        for kind, names, size, seed in _of_design(extent)
    ]
    order = np.random.default_rng(extent.first_seed).permutation(len(found))
    return [found[k] for k in order]


def _of_design(extent: Extent) -> Iterator[tuple[str, tuple[str, ...], float, int]]:
    first = extent.first_seed
    for seed in range(extent.nulls):
        yield "null", (), 1.0, first + seed
    for size in extent.sizes:
        for kind, known in {"effect": EFFECTS, "scale": SCALES, "stranger": STRANGERS}.items():
            for name in known:
                for seed in range(extent.seeds):
                    yield kind, (name,), size, first + seed
    for seed, pair in enumerate(_pairs(extent)):
        yield "pair", pair, 1.0, first + seed


def _pairs(extent: Extent) -> list[tuple[str, ...]]:
    """Pairs from different groups, drawn by lot."""
    group = {name: title for title, names in GROUPS.items() for name in names}
    every = [pair for pair in combinations(sorted(group), 2) if group[pair[0]] != group[pair[1]]]
    random = np.random.default_rng([extent.first_seed, 2])
    return [every[k] for k in random.permutation(len(every))[: extent.pairs]]
