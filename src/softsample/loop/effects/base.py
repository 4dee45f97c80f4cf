"""What an effect is: one small file that says what it does to a predicted record."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from softsample.constitutive.ogden import unit_modulus
from softsample.loop.specimen import Array, Specimen

Values = dict[str, float]
MODES = ("tension", "compression", "shear")

SOLID = unit_modulus(0.5, (-8.0, 16.0), 0.49, 1.0)
"""What the study's model is made of; effects on these constants have an `about` for other ones."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect, in the unit of files.

    Parameters
    ----------
    name, unit : str
        As written in the verdict.
    low, high : float
        Plausible range; where zero lies between, the sign is free. The neutral value may lie
        outside, if an effect that is there has a known size.
    nominal : float
        A plausible size, at which the signature is drawn.
    grid : tuple of float
        Values from which a fit starts, for parameters that enter nonlinearly (times, onsets);
        not where the effect has a corner in them, as no fit gets away from there.
    neutral : float
        Value without effect.
    limits : tuple of float
        Ends of the range at which a size may lie: limits of physics, such as all of a share. Others
        are limits of what is plausible.
    inside : bool
        Whether a fit that ends at another end explains nothing, as it always does with a size: an
        exponent or a period that wants to lie beyond is none.
    known : tuple of float
        Mean and standard deviation of a normal prior; none by default, so that all of the range is
        as likely.
    kind : str
        The kind of test that alone has it; by default all have.
    """

    name: str
    unit: str
    low: float
    high: float
    nominal: float
    grid: tuple[float, ...] = ()
    neutral: float = 0.0
    limits: tuple[float, ...] = ()
    inside: bool = False
    known: tuple[float, float] | None = None
    kind: str = ""

    @property
    def is_size(self) -> bool:
        """Whether the effect grows with this parameter; others say how it acts."""
        return not self.grid


@dataclass(frozen=True)
class Effect:
    """A physical or instrumental effect.

    A prediction goes through five stages, each by all active effects: the travel that reaches the
    sample, the elastic force per modulus, the tissue's history, what platen and grips pass on of
    its force, the instrument.

    Parameters
    ----------
    name : str
        One of the closed list of the design.
    title : str
        For people.
    parameters : tuple of Parameter
        With all sizes at their neutral values the effect is absent.
    source : str
        Where form and range come from.
    signature : str
        How it shows.
    confused_with : tuple of str
        Names it is hard to tell from.
    experiment : str
        The discriminating experiment.
    modes : tuple of str
        Kinds of tests that it changes; the functions below are not asked about others.
    identifiable : bool
        Whether any test of this protocol can show it.
    of_time : bool
        Whether it acts by the clock, so that records without time cannot show it.
    of_past : bool
        Whether it acts by where the platen has been, which is not known of a sweep without time:
        no loading led to where that begins.
    whole : callable, optional
        What the sizes take together of one whole in the course of a record: in the range of one of
        them, if they are parts of one. Proportional to the sizes.
    starts : tuple of dict
        Values of sizes from which a fit that has several minima sets out too. It is made whatever
        the linear estimate promises, of laws and relaxation where a smooth residual is left.
    idealised : bool
        Whether the model is known to leave it out: it comes before physics if records ask for it.
    is_law : bool
        Whether it is another elastic law, the first thing that a model may lack.
    has : tuple of str
        Effects whose part a law's own parameters play.
    like_geometry : bool
        Whether errors of geometry, mesh and element type may lie along it, where no record can
        show them: only what exceeds their stated sizes is evidence for it.
    beside : bool
        Whether what it adds to the elastic force is the same whatever the law.
    travel : callable, optional
        Displacement (n,) [m] that reaches the sample, of one of the platen. This and those below
        are what it does at each stage, by a specimen and the values of its parameters.
    compliance : callable, optional
        Compliance of what holds the sample [m/N].
    heights : callable, optional
        Depths [m] at which parts of the face lie, and these parts of the whole.
    elastic : callable, optional
        What is added to the elastic force per modulus (n,) [m2], of modulus fraction and travel.
    tissue, contact, instrument : callable, optional
        Force (n,) [N] that the tissue's history, what platen and grips pass on, and the
        instrument make of a force (n,) [N] and the travel (n,) [m].
    crosstalk : callable, optional
        Part of the force (n,) [N] along the displacement that the reading of a normal force has.
    """

    name: str
    title: str
    parameters: tuple[Parameter, ...]
    source: str
    signature: str
    confused_with: tuple[str, ...] = ()
    experiment: str = ""
    modes: tuple[str, ...] = MODES
    identifiable: bool = True
    of_time: bool = False
    of_past: bool = False
    idealised: bool = False
    is_law: bool = False
    has: tuple[str, ...] = ()
    like_geometry: bool = False
    beside: bool = False
    whole: Callable[[Values], float] | None = None
    starts: tuple[Values, ...] = ()
    travel: Callable[[Specimen, Array, Values], Array] | None = None
    compliance: Callable[[Specimen, Values], float] | None = None
    heights: Callable[[Specimen, Values], tuple[Array, Array]] | None = None
    elastic: Callable[[Specimen, float, Array, Values], Array] | None = None
    tissue: Callable[[Specimen, Array, Array, Values], Array] | None = None
    contact: Callable[[Specimen, Array, Array, Values], Array] | None = None
    instrument: Callable[[Specimen, Array, Array, Values], Array] | None = None
    crosstalk: Callable[[Specimen, Array, Values], Array] | None = None

    def excludes(self, other: "Effect") -> bool:
        """Whether no model has both: one effect twice, two laws, or what a law has of its own."""
        two_laws = self.is_law and other.is_law
        return two_laws or other.name in (self.name, *self.has) or self.name in other.has

    def of_kinds(self, kinds: Collection[str]) -> "Effect":
        """The same without what only other kinds of tests have: nothing shows it."""
        there = (p for p in self.parameters if p.kind in ("", *kinds))
        return replace(self, parameters=tuple(there))

    @property
    def points(self) -> list[Values]:
        """Points of the grid of how it acts, without sizes."""
        shapes = {p.name: p.grid for p in self.parameters if not p.is_size}
        return [dict(zip(shapes, point, strict=True)) for point in product(*shapes.values())]

    @property
    def shifts_travel(self) -> bool:
        """Whether it acts on the travel, or on that of parts of the face."""
        return bool(self.travel or self.compliance or self.heights)

    @property
    def only_instrument(self) -> bool:
        """Whether it acts on the instrument alone, not on the sample."""
        on_sample = self.elastic or self.tissue or self.contact or self.crosstalk
        return not (self.shifts_travel or on_sample)

    @property
    def sizes(self) -> tuple[Parameter, ...]:
        """Parameters that the effect grows with."""
        return tuple(p for p in self.parameters if p.is_size)

    def exceeds_the_whole(self, values: Values) -> bool:
        """Whether sizes that are parts of one whole take more than one of them may."""
        return self.whole is not None and self.whole(values) > max(p.high for p in self.sizes)

    def report(self, values: Values) -> dict[str, dict[str, Any]]:
        """Values of the parameters with their units."""
        return {p.name: {"value": values[p.name], "unit": p.unit} for p in self.parameters}

    def neutral(self) -> Values:
        """Values without effect; the others at the first of their grid."""
        return {p.name: p.neutral if p.is_size else p.grid[0] for p in self.parameters}
