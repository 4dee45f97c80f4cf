"""Responses of laws between runs of the solver on a coarse mesh.

Forces change by orders of magnitude with a law's numbers, but little against those of the
homogeneous test of the same law and nominal strain: that ratio is interpolated between runs. Runs
are where a fit goes: at its optimum, beside it along each parameter, and at the likeliest place of
all until a run there is what was predicted (space mapping).

References
----------
J. W. Bandler et al., IEEE Trans. Microw. Theory Tech. 42 (1994) 2536, doi:10.1109/22.339794.
"""

import logging
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import RBFInterpolator

from softsample.arrays import Array, Mask
from softsample.errors import SimulationError
from softsample.fem.boundary import Boundary
from softsample.fem.explicit import ExplicitModel
from softsample.laws.candidates import Candidate
from softsample.laws.fit import Problem
from softsample.laws.folds import Fits
from softsample.laws.response import HomogeneousResponse
from softsample.laws.test import LawTest
from softsample.response.unit import unit_runs

BESIDE = 0.08
"""Distance of the runs beside the first optimum, as a part of each range."""

ROUNDS = 12
"""Runs at an optimum, at most: four parameters far from the first guess take eight."""

MARGIN = 0.1
"""How far beyond its runs a ratio is interpolated, as a part of each range."""

SAME = 1e-3
"""Distance of two runs, in parts of the ranges, below which the later one stands for both."""

WEAK = 0.01
"""Part of the peak force below which a ratio is that of the next larger force."""


@dataclass(eq=False)
class SimulatedResponse:
    """A test of a piece as the solver shows it.

    Parameters
    ----------
    model, boundary
        Coarse mesh of the piece and what holds it.
    travel, loading_time : float
        Largest displacement of the runs [m], and their solver time [s].
    homogeneous : HomogeneousResponse
        The test of the ideal shape without friction, which the runs are compared with.
    """

    model: ExplicitModel
    boundary: Boundary
    travel: float
    loading_time: float
    homogeneous: HomogeneousResponse
    grid: Array = field(default_factory=lambda: np.empty(0))
    anchor: Array | float = 1.0
    guess: Array | float = 1.0
    places: dict[str, list[Array]] = field(default_factory=dict)
    ratios: dict[str, list[Array]] = field(default_factory=dict)
    _between: dict[str, RBFInterpolator] = field(default_factory=dict)

    def simulate(self, candidate: Candidate, shape: Array) -> Array:
        """Force per modulus (n,) [m2] of a run at its points, which are then in `grid`."""
        modulus = self.model.settings.reference_modulus_pa
        solid = candidate.material(shape, self.homogeneous.poisson_ratio, modulus)
        ((run, _),) = unit_runs(self.model, self.boundary, self.travel, [solid], self.loading_time)
        self.grid = run.displacement
        return np.asarray(run.force / modulus)

    def add(self, candidate: Candidate, shape: Array) -> float:
        """Run at a shape; returns how far the prediction was off, as a part of the peak."""
        force = self.simulate(candidate, shape)
        known = candidate.name in self.places
        expected = self.unit_force(candidate, shape, self.grid) / self.anchor if known else 0.0
        ratio = self._ratio_of(force, self.homogeneous.unit_force(candidate, shape, self.grid))
        self._between.pop(candidate.name, None)
        place = _scaled(candidate, shape)
        places, ratios = (d.setdefault(candidate.name, []) for d in (self.places, self.ratios))
        same = [
            k for k, known in enumerate(places) if np.abs(known - place).max(initial=0.0) < SAME
        ]
        for k in reversed(same):
            del places[k], ratios[k]
        places.append(place)
        ratios.append(ratio)
        return float(np.abs(force - expected).max() / np.abs(force).max())

    def unit_force(self, candidate: Candidate, shape: Array, displacement: Array) -> Array:
        """See `Response.unit_force`; of a law without runs with the ratio of the anchor's."""
        uniform = self.homogeneous.unit_force(candidate, shape, displacement)
        known = candidate.name in self.places
        ratio = (self._ratio(candidate, shape) if known else self.guess) * self.anchor
        if not len(self.grid):  # nothing was run yet
            return uniform
        return np.asarray(uniform * np.interp(displacement, self.grid, ratio))

    def _ratio(self, candidate: Candidate, shape: Array) -> Array:
        """Force over that of the homogeneous test at the points of the runs."""
        places, ratios = self.places[candidate.name], self.ratios[candidate.name]
        if not _spans(places):
            near = int(np.argmin([np.abs(p - _scaled(candidate, shape)).sum() for p in places]))
            return ratios[near]
        if candidate.name not in self._between:
            self._between[candidate.name] = RBFInterpolator(
                np.array(places), np.array(ratios), kernel="cubic", degree=1
            )
        low, high = np.min(places, axis=0) - MARGIN, np.max(places, axis=0) + MARGIN
        place = np.clip(_scaled(candidate, shape), low, high)
        return np.asarray(self._between[candidate.name](place[None])[0])

    def anchor_to(self, fine: Array, coarse: Array, uniform: Array) -> None:
        """Take the level of the study's mesh from forces (n,) of one law at the points of a run.

        Parameters
        ----------
        fine, coarse, uniform : (n,) float64
            On the study's mesh, on this one, and in the homogeneous test; the ratio of the last
            two is the first guess for all laws.
        """
        self.anchor, self.guess = self._ratio_of(fine, coarse), self._ratio_of(coarse, uniform)

    def _ratio_of(self, force: Array, reference: Array) -> Array:
        """Ratio of forces (n,); where the first is weak, that at its next larger one."""
        strong = np.abs(force) > WEAK * np.abs(force).max()
        return np.interp(self.grid, self.grid[strong], force[strong] / reference[strong])


def _spans(places: Sequence[Array]) -> bool:
    """Whether runs lie apart along each parameter, so that a plane goes through them."""
    plane = np.column_stack([np.ones(len(places)), np.array(places)])
    return plane.shape[1] > 1 and bool(np.linalg.matrix_rank(plane, tol=1e-3) == plane.shape[1])


def _scaled(candidate: Candidate, shape: Array) -> Array:
    """A shape in parts of the ranges, in their root where `Shape.starts` takes it."""
    parts = [s.part(value) for s, value in zip(candidate.shape, shape, strict=True)]
    return np.array(parts, dtype=np.float64)


def _unscaled(candidate: Candidate, place: Array) -> Array:
    values = [s.value(part) for s, part in zip(candidate.shape, place, strict=True)]
    return np.array(values, dtype=np.float64)


def simulate_law(
    candidate: Candidate,
    tests: Sequence[LawTest],
    tolerance: float,
    kept: Sequence[Mask],
) -> float | None:
    """Make the runs that a fit of a law needs, for all pieces of some tests.

    Parameters
    ----------
    tests : sequence of LawTest
        Those with a `SimulatedResponse` get runs.
    tolerance : float
        Largest error of the prediction at the optimum, as a part of the peak.
    kept : sequence of (n,) bool
        Points that are fitted.

    Returns
    -------
    float or None
        Error of the prediction at the last optimum; 0 in closed form, None if the solver cannot
        run the law there.
    """
    pieces = {id(t.response): t.response for t in tests
              if isinstance(t.response, SimulatedResponse)}  # fmt: skip
    if not pieces:
        return 0.0
    shape = Problem(tests, kept).fit(candidate).shape
    if _add(candidate, shape, pieces.values(), tests) is None:
        return None
    for place in _beside(_scaled(candidate, shape)):
        _add(candidate, _unscaled(candidate, place), pieces.values(), tests)
    error: float | None = 0.0
    for _ in range(ROUNDS if len(shape) else 0):
        before, shape = shape, Fits(tests).of(candidate, kept)[1].shape
        error = _add(candidate, shape, pieces.values(), tests)
        moved = np.abs(_scaled(candidate, shape) - _scaled(candidate, before)).max()
        if error is None or error < tolerance or moved < SAME:
            break
    return error


def _beside(place: Array) -> list[Array]:
    """Places to either side along each parameter, both inside where the range ends."""
    found = []
    for k, value in enumerate(place):
        ends = (value - BESIDE, value + BESIDE)
        if ends[0] < 0.0:
            ends = (value + BESIDE, value + 2.0 * BESIDE)
        elif ends[1] > 1.0:
            ends = (value - BESIDE, value - 2.0 * BESIDE)
        found += [np.concatenate([place[:k], [end], place[k + 1 :]]) for end in ends]
    return found


def _add(
    candidate: Candidate,
    shape: Array,
    pieces: Collection[SimulatedResponse],
    tests: Sequence[LawTest],
) -> float | None:
    """Run all pieces at a shape; the largest error of prediction, None if one cannot be run."""
    errors: list[float] = []
    try:
        errors += [piece.add(candidate, shape) for piece in pieces]
    except SimulationError as error:
        logging.getLogger(__name__).warning("%s at %s: %s", candidate.name, shape, error)
    for test in tests:
        test.forget()
    return max(errors) if len(errors) == len(pieces) else None
