"""What is simulated: a meshed sample, its test, and the steps of changed models."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from softsample.arrays import Array, Ids
from softsample.constitutive.material import Material
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import Boundary, ContactSettings, Ends, mode_boundary, rubbing
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.marks import MarkedImage
from softsample.meshing.mesh import HexMesh
from softsample.meshing.regions import stiffness_of
from softsample.meshing.sample import SampleMesh, mesh_ideal, mesh_real
from softsample.protocol import PRESSED_MODES
from softsample.response.bond import CONTACT, BondSettings, bonded_by_contact
from softsample.shapes import IdealShape, Indenter, element_size
from softsample.units import MM

RealGeometry = tuple[tuple[Array, Array, float], dict[str, MarkedImage]]
"""Signed distance [m], its origin [m] and spacing [m]; marks in the image by their column."""

INNER = (0.02, 0.98)
"""Modulus fractions between which changed models are simulated."""


@dataclass(frozen=True)
class PerturbationSettings:
    """Steps of the changed models; mirrors config `loop: perturbations:`.

    Parameters
    ----------
    fibre_ratio : float
        k1 over mu.
    tilt_deg : float
        Tilt of the platen [degrees], about x and y, either way.
    missing_bond : float
        Part of the glued area that is taken off, on either side of x and on one of y.
    shift_mm : float
        Shift of the surface [mm].
    frictions : sequence of float
        Coefficients of the runs whose platen goes back; that of brain on metal is about 0.1.
    precompression_mm : float
        Compression from which a glued sample is sheared [mm].
    """

    fibre_ratio: float = 0.1
    tilt_deg: float = 1.0
    missing_bond: float = 0.125
    shift_mm: float = 0.1
    frictions: Sequence[float] = (0.3, 0.15, 0.05)
    precompression_mm: float = 0.3


@dataclass(frozen=True)
class MechanicalTest:
    """The test of one sample, as runs of changed models repeat it.

    Parameters
    ----------
    mode : str
        One of `softsample.protocol.DIRECTIONS`.
    material : Material
        Two-term material at the optimum; its modulus only sets the scale.
    travel : float
        Largest displacement of the platen [m].
    contact, solver
        As of the config.
    steps : PerturbationSettings
        Steps of the changed models.
    ends : str or float
        `bonded`, `sliding`, or a coefficient of Coulomb friction.
    normal : bool
        Whether the force along z is wanted too, beside that along the displacement.
    many_fibres : bool
        Whether directions of the material are stated: fibres as stiff as they may be, too, and in
        the closed form.
    """

    mode: str
    material: Material
    travel: float
    contact: ContactSettings
    solver: SolverSettings
    steps: PerturbationSettings
    ends: Ends = "bonded"
    normal: bool = False
    many_fibres: bool = False

    @classmethod
    def of(cls, material: Material, travel: float, given: Mapping[str, Any]) -> Self:
        """From a material, a displacement [m], and the parameters of the job.

        These are `mode`, `ends`, `normal`, `contact`, `solver`, `perturbations` and `many_fibres`.
        """
        return cls(
            given["mode"],
            _of_both_terms(material),
            travel,
            ContactSettings(**given["contact"]),
            SolverSettings(**given["solver"]),
            PerturbationSettings(**given["perturbations"]),
            given["ends"],
            given["normal"],
            given["many_fibres"],
        )

    def at_fraction(self, fraction: float) -> Self:
        """The same test of a material with another modulus fraction."""
        solid = self.material
        other = unit_modulus(fraction, solid.alpha, solid.poisson_ratio, solid.shear_modulus)
        return replace(self, material=other)

    def held(self, sample: "MeshedSample") -> Boundary:
        """What holds a sample in the unchanged model."""
        return mode_boundary(sample.mesh, self.mode, sample.glued, self.contact, self.ends)

    @property
    def platen_contact(self) -> ContactSettings:
        """Contact of a pressed sample, its friction that of the ends."""
        ends = self.ends
        return self.contact if isinstance(ends, Indenter) else rubbing(self.contact, ends)


def _of_both_terms(material: Material) -> Material:
    """The material with some of each term: a change of a term that is absent shows nothing."""
    mu, fraction = material.shear_modulus, float(np.clip(material.mu1_fraction, *INNER))
    return unit_modulus(fraction, material.alpha, material.poisson_ratio, mu)


@dataclass(frozen=True, eq=False)
class MeshedSample:
    """A sample on the loop's coarse mesh.

    Parameters
    ----------
    mesh : HexMesh
        The sample [m].
    glued : (n,) int64
        Nodes glued to the moving platen.
    stiffness : (n_elements,) float64, optional
        Stiffness of each element relative to the sample's.
    """

    mesh: HexMesh
    glued: Ids
    stiffness: Array | None = None

    @classmethod
    def of(cls, made: SampleMesh, known: Mapping[int | str, float] | None = None) -> Self:
        """From a mesh, and the relative stiffness of its regions by their label."""
        stiffness = stiffness_of(made.cell_data, known)
        return cls(made.mesh, np.flatnonzero(made.point_data["glued"]), stiffness)

    def model(self, solver: SolverSettings) -> ExplicitModel:
        """Model of it."""
        return ExplicitModel(self.mesh, solver, self.stiffness)


def mesher(
    geometry: str, shape: IdealShape, real: Callable[[], RealGeometry], given: Mapping[str, Any]
) -> Callable[[float], MeshedSample]:
    """Meshes a sample as the loop does, with its surface moved out by a length [m].

    Parameters
    ----------
    geometry : str
        `real` or `ideal`.
    shape, real, given
        As of `sample_mesher`; `given` has `element_size_mm` and `region_stiffness` besides.
    """
    mesh = given["mesh"]
    size = element_size(shape, given["element_size_mm"] * MM, mesh["elements_across"])
    coarser = given["element_size_mm"] / mesh["element_size_mm"]
    make = sample_mesher(shape, size, coarser, real if geometry == "real" else None, given)
    known = given["region_stiffness"] if geometry == "real" else None
    return lambda out: MeshedSample.of(make(out), known)


def sample_mesher(
    shape: IdealShape,
    size: float,
    coarser: float,
    real: Callable[[], RealGeometry] | None,
    given: Mapping[str, Any],
) -> Callable[[float], SampleMesh]:
    """Meshes a sample with its surface moved out by a length [m].

    Parameters
    ----------
    shape : IdealShape
        Its idealised shape.
    size : float
        Wanted edge of the elements [m].
    coarser : float
        What that is of the edge of the study's mesh.
    real : callable, optional
        Reads, for the real geometry, its signed distance, where the origin of that is [m], and the
        spacing [m]; and `bond_mask` and `labels` if there are any. Without, the shape is meshed.
    given : mapping
        `mesh`, `mode`, `ends`, `preload_mm` and `bond` of the job; for what is bonded by contact
        `material`, `contact` and `solver` too.
    """
    mesh, preload = given["mesh"], given["preload_mm"] * MM
    if real is None:
        indenter = given["ends"] if isinstance(given["ends"], Indenter) else None
        return lambda out: mesh_ideal(shape.grown(out), size, indenter, coarser)
    grid, marks = real()
    segmented = mesh["boundary_shift_mm"] * MM
    bond = BondSettings(**given["bond"])

    def of_depth(out: float) -> SampleMesh:
        bond_mask, labels = marks.get("bond_mask"), marks.get("labels")
        shift = segmented + out
        return mesh_real(
            *grid, size, preload, boundary_shift=shift, bond_mask=bond_mask, labels=labels
        )

    if bond.rule != CONTACT or given["mode"] in PRESSED_MODES or "bond_mask" in marks:
        return of_depth
    law = given["material"]["alpha"], given["material"]["poisson_ratio"]
    runs = ContactSettings(**given["contact"]), SolverSettings(**given["solver"])
    regions = given["material"]["region_stiffness"]
    return lambda out: bonded_by_contact(of_depth(out), preload, bond, *law, *runs, regions)
