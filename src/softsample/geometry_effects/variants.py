"""Unit-modulus curves of a sample with its shape, its cuboid and their boundaries changed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import pandas as pd

from softsample.arrays import Ids
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import Boundary, ContactSettings, glued_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.geometry_effects.shapes import Shape, section_areas
from softsample.meshing.mesh import HexMesh
from softsample.meshing.sample import ideal_hexes
from softsample.protocol import PRESSED_MODES
from softsample.response.bond import CONTACT, BondSettings, touched_nodes
from softsample.response.unit import Progress, ResponseSettings, modulus_fractions, unit_runs
from softsample.shapes import IdealShape
from softsample.units import MM


@dataclass(frozen=True)
class EffectSettings:
    """Steps of the experiments; mirrors config `geometry_effects:`.

    Parameters
    ----------
    relief_factors : tuple of float
        Factors on the deviations of the top from its mean height.
    bond_depths_mm : tuple of float
        Ways of the platen below the highest point that decide what is glued, in place of the
        pre-load [mm].
    gap_factors : tuple of float
        Parts of the way from the cuboid's top up to the highest point at which the platen starts.
    """

    relief_factors: tuple[float, ...] = (0.5, 0.75, 1.25)
    bond_depths_mm: tuple[float, ...] = (0.5, 2.0)
    gap_factors: tuple[float, ...] = (0.5, 1.0)


@dataclass(frozen=True, eq=False)
class Variant:
    """A mesh and how it is held.

    Parameters
    ----------
    mesh : HexMesh
        The sample or a cuboid.
    bond_depth : float
        Nodes this near to the highest point are glued in tension and shear [m].
    gap : float
        Way of the platen before it meets the highest point in compression [m].
    bonded : (n,) int64, optional
        Nodes that are glued instead of those.
    """

    mesh: HexMesh
    bond_depth: float
    gap: float = 0.0
    bonded: Ids | None = None

    def boundary(self, mode: str, contact: ContactSettings) -> Boundary:
        """What holds the mesh in a test of a mode."""
        if mode == "compression":
            return platen_boundary(self.mesh, contact, gap=self.gap)
        glued = self.mesh.glued(self.bond_depth) if self.bonded is None else self.bonded
        return glued_boundary(self.mesh, mode, glued)


def variants(
    shape: Shape,
    mode: str,
    preload: float,
    settings: EffectSettings,
    touched: Ids | None = None,
    by_contact: bool = False,
) -> dict[str, Variant]:
    """All changed samples and cuboids of a test by name; `docs/geometry_effects.md` lists them.

    Parameters
    ----------
    mode : str
        Mode of the test; bonds are varied in tension and shear, the contact zero in compression.
    preload : float
        Depth of the glue [m]. Flat tops are glued as they are.
    touched : (n,) int64, optional
        Nodes of the sample that its platen touches in a simulated pre-load.
    by_contact : bool
        Whether these are bonded in the study; other shapes are glued to the depth all the same.
    """
    ideal, size = shape.ideal, shape.cuboid.edge_length

    def cuboid(area_ratio: float = 1.0, height_ratio: float = 1.0) -> Variant:
        length, width = (float(np.sqrt(area_ratio)) * side for side in (ideal.length, ideal.width))
        scaled = IdealShape(ideal.kind, length, width, height_ratio * ideal.height)
        return Variant(ideal_hexes(scaled, size), 0.0)

    top_area = float(section_areas(shape.levelled, np.array([ideal.height]))[0])
    levels = shape.real.highest * (np.arange(200) + 0.5) / 200
    section = float(section_areas(shape.real, levels).mean() * shape.real.highest / ideal.height)
    found = {
        "real": Variant(shape.real, preload, bonded=touched if by_contact else None),
        "levelled": Variant(shape.levelled, 0.0),
        "tapered": Variant(shape.tapered, 0.0),
        "cuboid": Variant(shape.cuboid, 0.0),
        "cuboid_with_relief": Variant(shape.cuboid_with_relief, preload),
        "tilt_alone": Variant(shape.with_top(shape.tilt_alone), preload),
        "without_tilt": Variant(shape.with_top(shape.without_tilt), preload),
        "cuboid_to_highest_point": cuboid(height_ratio=shape.real.highest / ideal.height),
        "cuboid_of_top_area": cuboid(top_area / ideal.area),
        "cuboid_of_volume": cuboid(section / ideal.area),
    }
    for factor in settings.relief_factors:
        mesh = shape.with_top(shape.scaled_relief(factor))
        found[f"relief_times_{factor:g}"] = Variant(mesh, preload)
    if mode == "compression":
        for factor in settings.gap_factors:
            gap = factor * max(0.0, shape.real.highest - ideal.height)
            found[f"gap_times_{factor:g}"] = replace(found["cuboid"], gap=gap)
    else:
        for depth in settings.bond_depths_mm:
            found[f"bond_depth_{depth:g}_mm"] = Variant(shape.real, 1e-3 * depth)
        if touched is not None:
            found["bond_by_contact"] = Variant(shape.real, preload, bonded=touched)
    return found


@dataclass(frozen=True)
class ShapeTest:
    """The test that is repeated with changed shapes.

    Parameters
    ----------
    mode : str
        One of `softsample.protocol.DIRECTIONS`.
    travel : float
        Largest displacement of the platen [m].
    preload : float
        Depth of the glue, and way of the platen in the pre-load [m].
    bond : BondSettings
        Of the study.
    alpha, poisson_ratio
        Of the material.
    fractions : sequence of float
        Modulus fractions mu1/mu; 1 stands for the one-term material.
    contact, solver
        As of the config.
    loading_time : float
        Solver time of the ramp that is slow enough for the real geometry [s].
    """

    mode: str
    travel: float
    preload: float
    bond: BondSettings
    alpha: tuple[float, float]
    poisson_ratio: float
    fractions: Sequence[float]
    contact: ContactSettings
    solver: SolverSettings
    loading_time: float

    @classmethod
    def of(cls, travel: float, loading_time: float, given: Mapping[str, Any]) -> Self:
        """From a displacement [m], a loading time [s], and the parameters of the job.

        These are `mode`, `preload_mm`, `bond`, `material`, `family`, `contact` and `solver`.
        """
        return cls(
            given["mode"],
            travel,
            MM * given["preload_mm"],
            BondSettings(**given["bond"]),
            given["material"]["alpha"],
            given["material"]["poisson_ratio"],
            modulus_fractions(ResponseSettings(**given["family"])).tolist(),
            ContactSettings(**given["contact"]),
            SolverSettings(**given["solver"]),
            loading_time,
        )

    def touched(self, shape: Shape) -> Ids | None:
        """Nodes of the sample that its platen touches in the pre-load, if it is glued then."""
        if self.mode in PRESSED_MODES:
            return None
        model, fill = ExplicitModel(shape.real, self.solver), MM * self.bond.fill_mm
        law = self.alpha, self.poisson_ratio
        return touched_nodes(model, self.preload, fill, *law, self.contact)

    def variants(self, shape: Shape, settings: EffectSettings) -> dict[str, Variant]:
        """All changed samples and cuboids by name, see `variants`."""
        by_contact = self.bond.rule == CONTACT
        return variants(shape, self.mode, self.preload, settings, self.touched(shape), by_contact)

    def simulate(self, found: dict[str, Variant], progress: Progress | None = None) -> pd.DataFrame:
        """Curves of all variants and modulus fractions in one table.

        Parameters
        ----------
        found
            Variants by name.
        progress
            Told the variant and the finished part.

        Returns
        -------
        DataFrame
            `variant`, `mu1_fraction`, `displacement` along the travel [m], `force_per_mu` [m2].
        """
        modulus, tables = self.solver.reference_modulus_pa, []
        solids = [unit_modulus(r, self.alpha, self.poisson_ratio, modulus) for r in self.fractions]
        for done, (name, variant) in enumerate(found.items()):
            if progress is not None:
                progress(name, done / len(found))
            model = ExplicitModel(variant.mesh, self.solver)
            boundary = variant.boundary(self.mode, self.contact)
            runs = unit_runs(model, boundary, self.travel, solids, self.loading_time)
            for fraction, (run, _) in zip(self.fractions, runs, strict=True):
                columns = {"displacement": run.displacement, "force_per_mu": run.force / modulus}
                tables.append(pd.DataFrame({"variant": name, "mu1_fraction": fraction, **columns}))
        return pd.concat(tables, ignore_index=True)
