"""Fit of a law: the modulus in closed form, shape parameters by Gauss-Newton within bounds.

References
----------
G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413, doi:10.1137/0710036 (variable
projection).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

from softsample.arrays import Array, Mask
from softsample.calibration.profile import end_met
from softsample.laws.candidates import Candidate
from softsample.laws.test import LawTest

Contacts = dict[str, tuple[float, float]]
Whiten = Callable[[int, Array], Array]

STEP = 1e-5
"""Step of differences, as a part of a parameter's range."""

STARTS = 4
"""Starts along each shape parameter."""

MOST_STARTS = 3
"""Starts that are followed to their end: those that fit best."""

IMPOSSIBLE = 10.0
"""Residual over the record of a shape that has no response."""


@dataclass(frozen=True, eq=False)
class LawFit:
    """A law fitted to tests.

    Parameters
    ----------
    mu : float
        Shear modulus [Pa], >= 0.
    shape : (n_shape,) float64
    cost : float
        Weighted sum of squares.
    contact : dict
        Where contact begins and the depth of the face [m], by sample whose contact is not known.
    """

    candidate: Candidate
    mu: float
    shape: Array
    cost: float
    contact: dict[str, tuple[float, float]] = field(default_factory=dict)

    def force(self, test: LawTest) -> Array:
        """Force (n,) [N] at the points of a test."""
        contact = self.contact.get(test.sample, ())
        return self.mu * test.unit_force(self.candidate, self.shape, contact)

    @property
    def bounds_met(self) -> list[str]:
        """Parameters that are at an end of their range, in words."""
        found = []
        for value, s in zip(self.shape, self.candidate.shape, strict=True):
            if end := end_met(s.part(value)):
                found.append(f"{s.name} at its {end}, {s.low if end == 'minimum' else s.high:g}")
        return found


class Problem:
    """Sum of squares of some points of some tests.

    Parameters
    ----------
    kept : sequence of (n,) bool
        Points of each that count.
    whiten : callable, optional
        White residual of the points that count of the k-th test; by default each test counts by
        its largest force, and its points share its weight.
    """

    def __init__(
        self, tests: Sequence[LawTest], kept: Sequence[Mask], whiten: Whiten | None = None
    ) -> None:
        self.pairs = [(k, t) for k, t in enumerate(tests) if kept[k].any()]
        self.kept, self.tests = kept, tests
        self.whiten = whiten or self._by_peak

    def _by_peak(self, k: int, values: Array) -> Array:
        peak = np.abs(self.tests[k].force[self.kept[k]]).max()
        return values / (peak * np.sqrt(len(values)))

    def stacked(self, values: Callable[[LawTest], Array]) -> Array:
        """White values of all points that count."""
        return np.concatenate([self.whiten(k, values(t)[self.kept[k]]) for k, t in self.pairs])

    @property
    def contacts(self) -> list[LawTest]:
        """Tests whose contact is fitted."""
        return [test for _, test in self.pairs if test.contact_depth]

    def unit(self, candidate: Candidate, shape: Array, contact: Contacts) -> Array:
        """White forces per modulus."""
        return self.stacked(
            lambda test: test.unit_force(candidate, shape, contact.get(test.sample, ()))
        )

    @property
    def measured(self) -> Array:
        """White forces of the records."""
        return self.stacked(lambda test: test.force)

    def projected(
        self,
        candidate: Candidate,
        shape: Array,
        contact: Contacts,
        y: Array,
        modulus: float | None = None,
    ) -> tuple[float, Array]:
        """The modulus >= 0 that fits best [Pa], or the given one, and the white residual."""
        unit = self.unit(candidate, shape, contact)
        if not np.all(np.isfinite(unit)):  # such a solid has no equilibrium, or is crushed
            return 0.0, IMPOSSIBLE * y
        mu = max(0.0, float(unit @ y) / max(float(unit @ unit), 1e-300))
        mu = mu if modulus is None else modulus
        return mu, y - mu * unit

    def fit(
        self,
        candidate: Candidate,
        first: Sequence[Array] = (),
        most: int = MOST_STARTS,
        held: dict[int, float] | None = None,
        modulus: float | None = None,
    ) -> LawFit:
        """The best of descents from several starts.

        Parameters
        ----------
        first : sequence of (n_shape,) float64, optional
            Shapes to set out from, before those of a grid that fit best.
        most : int
            Number of descents.
        held : dict, optional
            Values of shape parameters by index, which are not fitted.
        modulus : float, optional
            A modulus [Pa] that is not fitted.
        """
        variables = _Variables(candidate, self.contacts, held or {})
        y = self.measured

        def residual(x: Array) -> Array:
            return self.projected(candidate, *variables.of(x), y, modulus)[1]

        def square(x: Array) -> float:
            left = residual(x)
            return float(left @ left)

        starts = [variables.at(shape) for shape in first]
        if len(starts) < most:
            starts += sorted(map(variables.at, candidate.starts(STARTS)), key=square)
        found = []
        for start in starts[: most if len(starts[0]) else 1]:
            x = start
            if len(start):
                x = least_squares(
                    residual, np.clip(start, 1e-6, 1.0 - 1e-6), bounds=(0.0, 1.0),
                    diff_step=[STEP], xtol=1e-5, ftol=1e-6, max_nfev=30,
                ).x  # fmt: skip
            shape, contact = variables.of(x)
            mu, left = self.projected(candidate, shape, contact, y, modulus)
            found.append(LawFit(candidate, mu, shape, float(left @ left), contact))
        return min(found, key=lambda fit: fit.cost)

    def jacobian(self, fit: LawFit) -> Array:
        """Change of the white forces (n, 1 + n_shape) by ln(mu) and by each whole range."""
        low, high = fit.candidate.bounds
        base = fit.mu * self.unit(fit.candidate, fit.shape, fit.contact)
        columns = [base]
        for k, span in enumerate(high - low):
            ends = []
            for step in (-1e-4 * span, 1e-4 * span):
                shape = fit.shape.copy()
                shape[k] = np.clip(shape[k] + step, low[k], high[k])
                force = fit.mu * self.unit(fit.candidate, shape, fit.contact)
                there = bool(np.all(np.isfinite(force)))  # beyond may be no equilibrium
                ends.append((shape[k], force) if there else (fit.shape[k], base))
            (start, below), (end, above) = ends
            columns.append((above - below) * span / max(end - start, 1e-9 * span))
        return np.stack(columns, axis=1)


class _Variables:
    """Variables of a fit, each from 0 to 1: free shape parameters, then contacts.

    Parameters
    ----------
    candidate, contacts, held
        The law, tests whose contact is fitted, shape parameters that are not, by index.
    """

    def __init__(
        self, candidate: Candidate, contacts: Sequence[LawTest], held: dict[int, float]
    ) -> None:
        self.low, high = candidate.bounds
        self.span = high - self.low
        self.contacts, self.held = contacts, held
        self.free = [k for k in range(len(high)) if k not in held]

    def at(self, shape: Array) -> Array:
        """Variables of a shape; contact where the record says, the face a little uneven."""
        inner = (shape[self.free] - self.low[self.free]) / self.span[self.free]
        return np.concatenate([inner, np.tile([0.5, 0.3], len(self.contacts))])

    def of(self, x: Array) -> tuple[Array, Contacts]:
        """Shape and contacts of variables."""
        count = len(self.free)
        shape = np.empty(len(self.low))
        shape[self.free] = self.low[self.free] + x[:count] * self.span[self.free]
        for k, value in self.held.items():
            shape[k] = value
        pairs = x[count:].reshape(-1, 2)
        return shape, {
            test.sample: (
                float(2.0 * start - 1.0) * test.contact_depth, float(depth) * test.contact_depth
            )
            for test, (start, depth) in zip(self.contacts, pairs, strict=True)
        }  # fmt: skip
