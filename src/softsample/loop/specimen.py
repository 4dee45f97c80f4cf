"""One record as the diagnosis sees it: along the direction of loading, beside its response."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Array, Mask
from softsample.protocol import denoised, sweeps_through_zero, travel_sign
from softsample.records import Record
from softsample.response.elastic import Elastic

KINDS = {
    "pure_shear": "tension",
    "confined_compression": "compression",
    "indentation": "compression",
    "torsion": "shear",
}
"""Modes that are a pull, a push or a shear as far as machine and platens are concerned."""

FORCE, NORMAL = "force", "force_normal"
"""Channels of a record: along the displacement, and along +z in shear."""

AHEAD = 0.3
"""Time [s] by which a channel may be ahead of the other, at most."""


def blocks(values: Array, size: int) -> Array:
    """Means (n // size, ...) of consecutive groups of `size` samples; the rest is left out."""
    n = len(values) // size
    return np.asarray(values[: n * size].reshape(n, size, *values.shape[1:]).mean(axis=1))


@dataclass(frozen=True, eq=False)
class Specimen:
    """One channel of a test, all along the direction of loading (loading is positive).

    Parameters
    ----------
    name, mode : str
        Sample and mode of its test.
    time : (n,) float64
        Time [s], or number of the sample if time was not recorded.
    travel : (n,) float64
        Displacement of the platen as the machine reports it [m], its noise taken out.
    force : (n,) float64
        Force of the platen on the sample as the load cell reports it [N].
    phase : (n,) str
        `baseline`, `ramp`, `hold` or `unloading`.
    elastic : Elastic
        The response that predicts it.
    channel : str
        `FORCE`, or `NORMAL`, which is along +z.
    timed : bool
        Whether time was recorded.
    held_out : (n,) bool
        Samples that nothing is fitted to; none by default.
    partner : Specimen, optional
        Of a normal force, the force along the displacement of the same test.
    piece : str
        What was tested, which may have had other tests; by default the sample.
    stiffness : float
        Its modulus over that of the group.
    contact : float
        Displacement at which its compression begins, over that of the group [mm].
    material_z, material_x : int
        Directions of the material along the loading axis and along the shear, 1 to 3, negative for
        the opposite one; 0 if not stated.
    bond : float
        Log of its force if it is bonded by the other rule, over that of the model; zero if not.
    whole : Specimen, optional
        The test of which this is the first part.
    """

    name: str
    mode: str
    time: Array
    travel: Array
    force: Array
    phase: NDArray[np.str_]
    elastic: Elastic
    channel: str = FORCE
    timed: bool = True
    held_out: Mask = field(default_factory=lambda: np.zeros(0, bool))
    partner: Self | None = None
    piece: str = ""
    stiffness: float = 1.0
    contact: float = 0.0
    bond: float = 0.0
    material_z: int = 0
    material_x: int = 0
    whole: Self | None = None

    def __post_init__(self) -> None:
        if not self.piece:
            object.__setattr__(self, "piece", self.name)
        if len(self.held_out) != len(self.force):
            object.__setattr__(self, "held_out", np.zeros(len(self.force), bool))

    @classmethod
    def of_record(
        cls,
        name: str,
        mode: str,
        record: Record,
        elastic: Elastic,
        channel: str = FORCE,
        **stated: Any,
    ) -> Self:
        """One channel of a record, beside the response that predicts it, and what else is known."""
        sign = travel_sign(mode)
        force = record.force if channel == FORCE else np.asarray(record.force_normal)
        return cls(
            name,
            mode,
            record.clock,
            denoised(record.time, sign * record.displacement),
            np.asarray(sign * force if channel == FORCE else force),
            record.phase,
            elastic,
            channel,
            record.timed,
            **stated,
        )

    @property
    def way(self) -> tuple[str, int, int]:
        """Mode, and the directions of the material in which it loads, either sign."""
        return self.mode, abs(self.material_z), abs(self.material_x)

    def with_own(self, **known: Mapping[str, float]) -> Self:
        """The same with what is its specimen's own, `stiffness` or `contact`, if that is known."""
        own: dict[str, Any] = {k: of[self.piece] for k, of in known.items() if self.piece in of}
        partner = self.partner and self.partner.with_own(**known)
        return replace(self, **own, partner=partner) if own else self

    def reduced(self, size: int) -> Self:
        """The same with groups of `size` samples replaced by their means; the rest is left out.

        A group with a sample that is held out is held out.
        """
        first = slice(0, len(self.time) // size * size, size)
        return replace(
            self,
            time=blocks(self.time, size),
            travel=blocks(self.travel, size),
            force=blocks(self.force, size),
            phase=self.phase[first],
            held_out=self.out(size),
            partner=self.partner and self.partner.reduced(size),
        )

    def until(self, n: int) -> Self:
        """The first `n` samples of the same test."""
        kept = ("time", "travel", "force", "phase", "held_out")
        parts = {name: getattr(self, name)[:n] for name in kept}
        partner, whole = self.partner and self.partner.until(n), self.whole or self
        return self if n == len(self.time) else replace(self, **parts, partner=partner, whole=whole)

    def out(self, size: int) -> Mask:
        """Blocks (n // size,) of which any sample is held out."""
        return np.asarray(blocks(self.held_out.astype(float), size) > 0.0)

    @property
    def clock(self) -> Array:
        """Time since the record began (n,) [s]."""
        return self.time - self.time[0]

    @property
    def is_sweep(self) -> bool:
        """Whether it has no time and goes to both sides, as mean curves over both directions do."""
        return not self.timed and sweeps_through_zero(self.travel)

    @cached_property
    def loading_time(self) -> float:
        """Time that the platen takes to its largest displacement at its usual speed [s].

        That is the mean over what it travels, to which holds add nothing.
        """
        if self.whole:
            return self.whole.loading_time
        steps = np.abs(np.diff(self.travel))
        return float(self.reach * steps.sum() / np.sum(steps**2 / np.diff(self.time)))

    @property
    def stretches(self) -> list[slice]:
        """Samples of each stretch of one phase, held out or not, in order."""
        other = self.phase[1:] != self.phase[:-1]
        ends = np.flatnonzero(other | (self.held_out[1:] != self.held_out[:-1])) + 1
        corners = [0, *ends.tolist(), len(self.phase)]
        return [slice(a, b) for a, b in pairwise(corners)]

    @cached_property
    def kind(self) -> str:
        """What the platen does: `tension`, `compression` or `shear`."""
        return KINDS.get(self.mode, self.mode)

    @property
    def cell(self) -> str:
        """What its cell measures: `torque` or `force`."""
        return "torque" if self.mode == "torsion" else "force"

    @property
    def axis_sign(self) -> float:
        """Direction of loading along the machine's axis: -1 where the platen presses."""
        return travel_sign(self.mode)

    @cached_property
    def reach(self) -> float:
        """Largest displacement either way [m]."""
        return self.whole.reach if self.whole else float(np.abs(self.travel).max())

    @property
    def strain(self) -> float:
        """Largest displacement over the height; the displacement [m] if no height is known."""
        return self.reach / (self.elastic.height or 1.0)

    @property
    def peak(self) -> float:
        """Largest force of what is fitted [N], or of all if nothing is."""
        fitted = self.force[~self.held_out]
        return float(np.abs(fitted if len(fitted) else self.force).max())
