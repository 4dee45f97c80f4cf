"""One loading as a law is fitted to it: few points, and the response that predicts them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, Self

import numpy as np

from softsample.arrays import Array, Mask
from softsample.laws.candidates import Candidate
from softsample.protocol import PRESSED_MODES, travel_sign
from softsample.record_noise import white_noise
from softsample.records import Record

POINTS = 40
"""Points of a loading at most: a law is smooth, and what is rough is noise."""

APPROACH = 0.01
"""Displacement before contact from which a platen came from above, as a part of the height."""

CONTACT_DEPTH = 0.2
"""Depth over which a face of stated dimensions may be uneven, as a part of the height. Chosen on
the six gels of docs/laws.md; 0.3 does as well on three of them, 0.1 less."""

LEVELS = 12
"""Heights that stand for an uneven face."""

FINE = 81
"""Points of a response between which contact is interpolated."""


class Response(Protocol):
    """Response of one piece in one test."""

    def unit_force(self, candidate: Candidate, shape: Array, displacement: Array) -> Array:
        """Force per shear modulus (n,) [m2] at displacements (n,) [m], both along the loading."""


@dataclass(frozen=True, eq=False)
class LawTest:
    """A loading of one sample.

    Parameters
    ----------
    sample, mode, specimen : str
        Of the row of the study.
    displacement, force : (n,) float64
        Along the loading [m, N].
    noise : float
        Standard deviation of a point [N].
    response : Response
        What predicts it.
    contact_depth : float
        Largest depth [m] over which an uneven face may meet the platen, and largest error of where
        contact begins, to either side; 0 if contact is known.
    held_out : (n,) bool
        Points that the study holds out; none by default.
    scale_error : float
        Standard deviation of the scale of the response, as a part of it: what mesh and element
        type leave open.
    contact_zero : float
        Standard deviation of the displacement at which contact begins [m]; 0 where it is fitted or
        known.
    reached : float
        Part of the loading that the response covers; what is beyond is left out.
    """

    sample: str
    mode: str
    specimen: str
    displacement: Array
    force: Array
    noise: float
    response: Response
    contact_depth: float = 0.0
    held_out: Mask = field(default_factory=lambda: np.zeros(0, bool))
    scale_error: float = 0.0
    contact_zero: float = 0.0
    reached: float = 1.0
    _known: dict[tuple[str, bytes], Array] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        if len(self.held_out) != len(self.force):
            object.__setattr__(self, "held_out", np.zeros(len(self.force), bool))

    @classmethod
    def of(
        cls,
        row: Mapping[str, str],
        record: Record,
        held_out: Mask,
        response: Response,
        height: float,
        stated: bool,
        scale_error: float = 0.0,
        contact_zero: float = 0.0,
        travel: float = np.inf,
    ) -> Self:
        """From the calibrated loading of a record.

        Parameters
        ----------
        row : mapping of str
            Of the study table, defaults filled in.
        held_out : (n_record,) bool
            Samples of it that the study holds out.
        height : float
            Of the undeformed sample [m].
        stated : bool
            Whether its dimensions were stated: a platen that came from above the sample then finds
            contact, and how even the face is.
        scale_error, contact_zero : float
            Of the response, as a part of it, and of the highest point of an image [m].
        travel : float
            Largest displacement of the response [m].
        """
        sign, calibrated = travel_sign(row["mode"]), record.calibrated.astype(bool)
        last = float(np.max(sign * record.displacement, where=calibrated, initial=0.0))
        chosen = calibrated & (sign * record.displacement <= travel * (1.0 + 1e-9))
        way, force = sign * record.displacement[chosen], sign * record.force[chosen]
        points = reduced(way, force, held_out[chosen])
        found = row["mode"] in PRESSED_MODES and stated and way.min() < -APPROACH * height
        at = record.clock[chosen] if record.timed else way
        noise = white_noise(at, force)[0] / np.sqrt(points[3])
        return cls(
            row["sample"], row["mode"], row["specimen"], points[0], points[1], noise, response,
            CONTACT_DEPTH * height if found else 0.0, points[2], scale_error,
            0.0 if stated or row["mode"] != "compression" else contact_zero,
            float(way.max()) / last if last > way.max() else 1.0,
        )  # fmt: skip

    @property
    def stroke(self) -> float:
        """Largest displacement [m]."""
        return float(self.displacement.max())

    def unit_force(
        self, candidate: Candidate, shape: Array, contact: Sequence[float] = ()
    ) -> Array:
        """Force per shear modulus (n,) [m2] at the points; folds ask for the same ones again.

        A platen that presses has no force before contact.

        Parameters
        ----------
        candidate, shape
            The law and its shape parameters.
        contact : (2,) sequence of float, optional
            Where contact begins [m], and the depth [m] over which the heights of the face are
            spread evenly; of a test with `contact_depth`.
        """
        key = candidate.name, shape.tobytes()
        if key not in self._known:
            force = self.response.unit_force(candidate, shape, self.grid)
            away = (self.grid <= 0.0) & (self.mode in PRESSED_MODES)
            self._known[key] = np.where(away, 0.0, force)
        if not self.contact_depth:
            return self._known[key]
        start, depth = contact or (0.0, 0.0)
        levels = start + depth * (np.arange(LEVELS) + 0.5) / LEVELS
        way = np.subtract.outer(self.displacement, levels)
        return np.asarray(np.interp(way, self.grid, self._known[key]).mean(axis=1))

    def forget(self) -> None:
        """Ask the response anew: it knows more."""
        self._known.clear()

    @property
    def grid(self) -> Array:
        """Displacements at which the response is asked for [m]."""
        if not self.contact_depth:
            return self.displacement
        return np.linspace(0.0, self.stroke + self.contact_depth, FINE)


def reduced(
    displacement: Array, force: Array, held_out: Mask, points: int = POINTS
) -> tuple[Array, Array, Mask, float]:
    """Means over `points` equal parts of the displacement, and the points in a mean.

    A mean with a point that is held out is held out.
    """
    if len(force) <= points:
        order = np.argsort(displacement, kind="stable")
        return displacement[order], force[order], held_out[order], 1.0
    edges = np.linspace(displacement.min(), displacement.max(), points + 1)
    part = np.clip(np.searchsorted(edges, displacement, side="right") - 1, 0, points - 1)
    count = np.bincount(part, minlength=points)
    there = count > 0
    means = [
        np.bincount(part, values, points)[there] / count[there]
        for values in (displacement, force, held_out.astype(float))
    ]
    return means[0], means[1], means[2] > 0.0, float(np.median(count[there]))
