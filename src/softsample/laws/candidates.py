"""Laws that may be chosen: the dictionary, and sums of at most two of its terms."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Self

import numpy as np

from softsample.arrays import Array
from softsample.constitutive.laws import LAWS
from softsample.constitutive.material import Material, Term
from softsample.errors import InputError

Range = tuple[float, float]

WRITTEN = re.compile(r"\s*(\w+)\s*(?:\((.*)\))?\s*")
"""A term in the settings: a law, and ranges of its shape parameters."""

FRACTION = "mu1_fraction"
"""Part of the shear modulus that is in the first of two terms."""

WIDE = 10.0
"""A range from 0 to this or more is searched from starts that are evenly spaced in its root."""


@dataclass(frozen=True)
class Shape:
    """A shape parameter of a candidate.

    Parameters
    ----------
    name : str
        Name in tables, with the number of its term where both have it.
    low, high, default : float
        Range of the search, and a value to set out from.
    """

    name: str
    low: float
    high: float
    default: float

    def starts(self, count: int) -> Array:
        """Inner points (count,) of the range, in its root where it is wide and begins near zero."""
        return np.array([self.value((k + 0.5) / count) for k in range(count)])

    @property
    def power(self) -> float:
        """Of the part of the range in which the parameter is searched."""
        return 2.0 if self.low >= 0.0 and self.high >= WIDE else 1.0

    def value(self, part: float) -> float:
        """The value at a part of the range, from 0 to 1."""
        inner = float(np.clip(part, 0.0, 1.0)) ** self.power
        return self.low + inner * (self.high - self.low)

    def part(self, value: float) -> float:
        """The part of the range at a value."""
        return float(((value - self.low) / (self.high - self.low)) ** (1.0 / self.power))


@dataclass(frozen=True)
class Candidate:
    """A law or a sum of two, per shear modulus.

    Parameters
    ----------
    laws : tuple of str
        Names in `softsample.constitutive.laws.LAWS`, joined by `+` in tables.
    fixed : tuple of tuple of float
        Shape parameters of the terms that are not fitted; none by default.
    ranges : tuple of tuple of (low, high)
        Of the shape parameters of each term, in place of the law's.
    """

    laws: tuple[str, ...]
    fixed: tuple[tuple[float, ...], ...] = ()
    ranges: tuple[tuple[Range, ...], ...] = ()

    @classmethod
    def of(cls, name: str) -> Self:
        """From its name in the settings, such as `neo_hooke+ogden` or `ogden(-18:-2)+ogden(4:26)`.

        Raises
        ------
        InputError
            If a law is unknown or no solid alone, there are more than two, or ranges are no
            `low:high` of each shape parameter.
        """
        terms = [WRITTEN.fullmatch(part) for part in name.split("+")]
        laws = tuple(term[1] if term else "" for term in terms)
        solids = [law for law in LAWS if law != "fibre"]
        unknown = [law for law in laws if law not in solids]
        if unknown or len(laws) > 2:
            raise InputError(
                f"laws.candidates: {name!r} is no sum of one or two of {', '.join(solids)}"
            )
        written = [term[2] for term in terms if term]
        if not any(written):
            return cls(laws)
        pairs = zip(laws, written, strict=True)
        return cls(laws, ranges=tuple(_ranges(name, law, text) for law, text in pairs))

    @classmethod
    def of_pair(cls, alpha: Sequence[float]) -> Self:
        """Two Ogden terms of the study's exponents."""
        return cls(("ogden",) * len(alpha), tuple((float(a),) for a in alpha))

    @property
    def name(self) -> str:
        """Name in tables."""
        return "+".join(map("".join, zip(self.laws, self._numbers(""), strict=True)))

    @property
    def title(self) -> str:
        """Name in words."""
        titles = [LAWS[law].title for law in self.laws]
        return " + ".join(map("".join, zip(titles, self._numbers(" "), strict=True)))

    def _numbers(self, before: str) -> list[str]:
        """Fixed numbers or ranges of each term in brackets, empty where there are none."""
        fixed = [[f"{x:g}" for x in numbers] for numbers in self.fixed]
        ranges = [[f"{low:g}:{high:g}" for low, high in ends] for ends in self.ranges]
        numbers = fixed or ranges or [[] for _ in self.laws]
        return [f"{before}({', '.join(own)})" if own else "" for own in numbers]

    @property
    def shape(self) -> tuple[Shape, ...]:
        """Shape parameters that are fitted: those of the terms, after the first one's share."""
        found = [Shape(FRACTION, 0.0, 1.0, 0.5)] if len(self.laws) > 1 else []
        for number, law in enumerate(() if self.fixed else self.laws, 1):
            end = str(number) if self.laws.count(law) > 1 else ""
            ranges = (self.ranges[number - 1] if self.ranges else ()) or (
                (p.low, p.high) for p in LAWS[law].shape
            )
            found += [
                Shape(p.name + end, low, high, float(np.clip(p.default, low, high)))
                for p, (low, high) in zip(LAWS[law].shape, ranges, strict=True)
            ]
        return tuple(found)

    @property
    def size(self) -> int:
        """Number of parameters, the modulus counted."""
        return 1 + len(self.shape)

    @property
    def bounds(self) -> Array:
        """Ends of the ranges (2, n_shape)."""
        ends = [(s.low, s.high) for s in self.shape]
        return np.array(ends, dtype=np.float64).reshape(-1, 2).T

    def material(
        self, shape: Sequence[float] | Array, poisson_ratio: float, modulus: float
    ) -> Material:
        """The material of a shear modulus [Pa]; a term without modulus is left out."""
        numbers = [float(x) for x in shape]
        share = numbers.pop(0) if len(self.laws) > 1 else 1.0
        terms = []
        for k, (law, part) in enumerate(zip(self.laws, (share, 1.0 - share), strict=False)):
            count = len(LAWS[law].shape)
            own = self.fixed[k] if self.fixed else numbers[:count]
            numbers = numbers if self.fixed else numbers[count:]
            if part > 0.0:
                terms.append(Term(law, part * modulus, tuple(own)))
        return Material(tuple(terms), poisson_ratio)

    def starts(self, count: int) -> list[Array]:
        """Shapes from which a fit sets out: defaults, `count` points of each range, in order."""
        grids = [s.starts(count if s.name != FRACTION else 1) for s in self.shape]
        points = [np.array([s.default for s in self.shape])]
        points += [np.array(point) for point in product(*grids)]
        if len(self.laws) == 2 and self.laws[0] == self.laws[1] and not self.fixed:
            points = [p for p in points if p[1] < p[-1]]
        return points


def _ranges(name: str, law: str, text: str | None) -> tuple[Range, ...]:
    """Ranges of a law's shape parameters, in the name of a candidate; none if it has no text."""
    parameters = LAWS[law].shape
    if text is None:
        return ()
    try:
        found = []
        for part, p in zip(text.split(","), parameters, strict=True):
            low, high = map(float, part.split(":"))
            if not p.low <= low < high <= p.high:
                raise ValueError
            found.append((low, high))
    except ValueError:
        limits = ", ".join(f"{p.name} in {p.low:g}:{p.high:g}" for p in parameters) or "none"
        raise InputError(
            f"laws.candidates: {name!r}: {law}({text}) has no range low:high of each shape "
            f"parameter within that of the law; it has {limits}"
        ) from None
    return tuple(found)
