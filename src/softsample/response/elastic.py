"""Elastic response of one test and how it changes with the model: what a record is predicted by."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Self

import numpy as np
import pandas as pd

from softsample.arrays import Array
from softsample.constitutive.material import Material, compressibility
from softsample.protocol import PRESSED_MODES
from softsample.response.changes import (
    LESS,
    NEARER,
    between_fractions,
    for_all_fractions,
    lower_ratio,
    read_changes,
    split_laws,
)
from softsample.response.curves import ResponseCurves
from softsample.response.law_response import LawResponse
from softsample.response.memory import remembered
from softsample.shapes import IdealShape

# ASSUME: no sample is denser than 1.2 g/cm3, as filled silicones are; wet tissue has 1.0 to 1.1.
HEAVIEST = 1.2e3 * 9.81
"""Weight of a volume, at most [N/m3]."""

LEAST_PART = 0.05
"""What a compliance is of the model's at least when the Poisson's ratio changes."""


@dataclass(frozen=True, eq=False)
class Tables:
    """Simulated response of one piece.

    Parameters
    ----------
    curves : DataFrame
        Its unit-modulus response.
    changes : sequence of DataFrame
        Its changes by perturbations of the model.
    solid : Material
        Of which the model is made.
    real : DataFrame, optional
        Response of the real geometry, if the model is the ideal one.
    bond : mapping, optional
        What either rule of the bond makes of it (`softsample.response.bond.by_rule`).
    release : bool
        Whether a platen leaves a sample that would pull on it.
    """

    curves: pd.DataFrame
    changes: Sequence[pd.DataFrame]
    solid: Material
    real: pd.DataFrame | None = None
    bond: Mapping[str, Any] | None = None
    release: bool = True


@dataclass(frozen=True, eq=False)
class Elastic:
    """Force of the elastic model per shear modulus, and how it changes with the model.

    Parameters
    ----------
    curves : ResponseCurves
        Curves for all modulus fractions mu1 / mu.
    perturbations : mapping of ResponseCurves
        Change of the force per modulus [m2] when the model is changed by the step that the
        perturbation is named after, for all fractions.
    contact : bool
        Whether a platen meets the sample: no force before zero displacement.
    poisson_ratio : float
        Of the model; changes of it go from there.
    laws : LawResponse, optional
        What other laws would change.
    most_push : float
        Push per modulus [m2] at which a sample that was pulled buckles on unloading.
    height, weight : float, optional
        Of the idealised shape [m], and the most that it weighs [N].
    release : bool
        Whether a platen leaves a sample that would pull on it.
    """

    curves: ResponseCurves
    perturbations: Mapping[str, ResponseCurves] = field(default_factory=dict)
    contact: bool = False
    poisson_ratio: float = 0.49
    laws: LawResponse | None = None
    most_push: float = np.inf
    height: float | None = None
    weight: float | None = None
    release: bool = True

    @classmethod
    def of_tables(
        cls,
        mode: str,
        tables: Tables,
        channel: str = "force",
        shape: IdealShape | None = None,
    ) -> Self:
        """From the files of the workflow.

        Parameters
        ----------
        mode : str
            Of the sample's test.
        tables : Tables
            Its response.
        channel : str
            `force`, along the displacement, or `force_normal`.
        shape : IdealShape, optional
            Idealised shape, for the response to other laws, and for how slender it is.
        """
        found = ResponseCurves.of_table(tables.curves, mode, channel)
        perturbations: dict[str, ResponseCurves] = {}
        runs: dict[float, Array] = {}
        for table in tables.changes:
            of_fraction, fractions = {}, table["mu1_fraction"].unique()
            for fraction in map(float, fractions):
                part = table[table["mu1_fraction"] == fraction]
                simulated, single = split_laws(read_changes(part, found, mode, channel))
                of_fraction[fraction] = for_all_fractions(
                    simulated, found, fraction, exact=len(fractions) > 1
                )
                runs |= single
            perturbations |= between_fractions(of_fraction)
        if tables.real is not None:
            difference = ResponseCurves.of_table(tables.real, mode, channel).minus(found)
            perturbations["real_geometry"] = difference
        solid, across = tables.solid, channel != "force"
        pressed, nu = mode in PRESSED_MODES and not across, solid.poisson_ratio
        laws = LawResponse(found, shape, mode, solid.alpha, nu, across, runs) if shape else None
        push = np.inf
        if shape and mode == "tension" and not across:  # ASSUME: Euler's load of clamped ends.
            push = 12.0 * shape.area * (np.pi * shape.gyration / shape.height) ** 2
        height, weight = (shape.height, HEAVIEST * shape.volume) if shape else (None, None)
        return cls(found, perturbations, pressed, nu, laws, push, height, weight, tables.release)

    @cached_property
    def grain(self) -> float:
        """Discretisation noise of a simulated curve, as a part of its peak.

        That of the real geometry counts where the model may turn to it.
        """
        curves, difference = self.curves, self.perturbations.get("real_geometry")
        peaks = np.array([np.abs(curves.curve(r)).max() for r in curves.fractions])
        own = float(np.mean(curves.grain / peaks))
        if difference is None:
            return own
        real = [np.abs(curves.curve(r) + difference.curve(r)).max() for r in difference.fractions]
        return float(np.hypot(own, np.mean(difference.grain / np.array(real))))

    def force_per_mu(self, fraction: float, displacement: Array) -> Array:
        """Force along the displacement per shear modulus [m2] at platen displacements [m]."""
        return self.curves.force_per_mu(fraction, displacement)

    def change_per_mu(self, perturbation: str, fraction: float, displacement: Array) -> Array:
        """Change of that force [m2] by one step of a perturbation; none if it was not simulated."""
        if perturbation not in self.perturbations:
            return np.zeros_like(displacement)
        return self.perturbations[perturbation].force_per_mu(fraction, displacement)

    def exponents_change_per_mu(
        self, fraction: float, displacement: Array, alpha: Sequence[float]
    ) -> Array:
        """Change of that force [m2] by other exponents; none if laws are not known."""
        if self.laws is None:
            return np.zeros_like(displacement)
        return self.laws.ogden_change(fraction, displacement, alpha)

    def one_term_change_per_mu(self, fraction: float, displacement: Array, alpha: float) -> Array:
        """Change of that force [m2] by one Ogden term in place of two; none if laws are unknown."""
        if self.laws is None:
            return np.zeros_like(displacement)
        alone = self.force_per_mu(1.0, displacement)
        change = self.laws.ogden_change(1.0, displacement, (alpha, self.laws.alpha[1]))
        return np.asarray(alone + change - self.force_per_mu(fraction, displacement))

    @property
    def knows_foams(self) -> bool:
        """Whether the force of a foam is known."""
        return self.laws is not None and self.laws.knows_foams

    def foam_change_per_mu(
        self, fraction: float, displacement: Array, alpha: float, nu: float
    ) -> Array:
        """Change of that force [m2] by a foam in place of the model; none if it is not known."""
        if self.laws is None or not self.knows_foams:
            return np.zeros_like(displacement)
        return self.laws.foam_change(fraction, displacement, alpha, nu)

    def softer_change_per_mu(
        self, fraction: float, displacement: Array, times: Array | float
    ) -> Array:
        """Change of that force [m2] if the shear modulus over the bulk modulus is another.

        `times` the model's, a number or (n,). In a homogeneous deformation the force is a quotient
        of two linear functions of it; here it is the one through the model and the runs with
        Poisson's ratios lower by `LESS`. Of bonded cuboids of 0.49 it is within 0.7 % of the peak
        of runs down to 0.40, 1.6 % at 0.35, and a third of the change at 0.498.
        """
        x = np.asarray(times) - 1.0
        slope, share = self._more_compressible(fraction, displacement)
        return np.asarray(slope * x / np.maximum(1.0 + share * x, LEAST_PART))

    @remembered
    def _more_compressible(self, fraction: float, displacement: Array) -> Array:
        """Slope [m2] of that change, and part of the compliance that is of the volume (2, n)."""
        steps = [s for s in (*LESS, NEARER) if lower_ratio(s) in self.perturbations][:2]
        if len(steps) < 2:
            return np.zeros((2, *displacement.shape))
        own = compressibility(self.poisson_ratio)
        first, second = (compressibility(self.poisson_ratio - s) / own - 1.0 for s in steps)
        one, two = (self.change_per_mu(lower_ratio(s), fraction, displacement) for s in steps)
        bent, apart = one / first - two / second, two - one
        share = np.divide(bent, apart, out=np.zeros_like(one), where=apart != 0.0).clip(0.0, 1.0)
        near, far = (x / (1.0 + share * x) for x in (first, second))
        return np.stack([(near * one + far * two) / (near**2 + far**2), share])

    def ratio_change_per_mu(
        self, fraction: float, displacement: Array, poisson_ratio: float
    ) -> Array:
        """Change of that force [m2] by another Poisson's ratio than the model's."""
        times = compressibility(poisson_ratio) / compressibility(self.poisson_ratio)
        return self.softer_change_per_mu(fraction, displacement, times)
