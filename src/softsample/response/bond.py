"""Which nodes of the top a test bonds to the platen: by height, or by a simulated pre-load."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.ogden import unit_modulus
from softsample.errors import InputError
from softsample.fem.boundary import ContactSettings, platen_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.fem.kernels import PLATEN
from softsample.meshing.mesh import HexMesh
from softsample.meshing.regions import relative_stiffness
from softsample.meshing.sample import SampleMesh
from softsample.response.unit import find_pace, shortest_loading_time

Ids = NDArray[np.int64]

MM = 1e-3

# ASSUME: the bond does not hang on how the modulus is split between the two terms.
EVEN = 0.5
"""Modulus fraction of the sample that a pre-load presses."""

CONTACT = "contact"
"""Rule by which what the pre-load presses on the platen is bonded."""


@dataclass(frozen=True)
class BondSettings:
    """Mirrors config `bond:`.

    Parameters
    ----------
    rule : str
        `within_depth`: surface nodes that the platen would pass on its way of the pre-load if the
        sample did not yield; `contact`: those that touch it at the end of that way if it does.
    fill_mm : float
        Gap that glue fills, with the rule `contact` [mm].
    """

    rule: str = "within_depth"
    fill_mm: float = 0.0


def touched_nodes(
    mesh: HexMesh,
    preload: float,
    fill: float,
    alpha: Sequence[float],
    poisson_ratio: float,
    contact: ContactSettings,
    solver: SolverSettings,
    stiffness: NDArray[np.float64] | None = None,
) -> Ids:
    """Nodes of the surface that a flat, rough platen touches, or nearly, in the pre-load.

    The sample rests on its base, unloaded; the platen comes down from its highest point.

    Parameters
    ----------
    mesh : HexMesh
        The sample [m].
    preload : float
        Way of the platen [m].
    fill : float
        Gap between surface and platen that counts as touched [m].
    alpha : sequence of float
        Exponents of the two terms of the sample's material, which has as much of each.
    poisson_ratio : float
        Of that material.
    contact, solver
        As of the config; nothing slips.
    stiffness : (n_elements,) float64, optional
        Stiffness of each element relative to the sample's.

    Returns
    -------
    (n,) int64
        Sorted ids.

    Raises
    ------
    SimulationError
        If the pre-load cannot be simulated.
    """
    material = unit_modulus(EVEN, alpha, poisson_ratio, solver.reference_modulus_pa)
    model = ExplicitModel(mesh, solver, stiffness)
    boundary = platen_boundary(mesh, replace(contact, friction=None, base_friction=None))
    run = find_pace(
        lambda loading_time: model.run(material, boundary, preload, loading_time=loading_time),
        shortest_loading_time(model),
        solver.curve_error_percent,
    ).run
    surface = mesh.boundary
    gap = mesh.highest - preload - (mesh.points + run.displacement_field)[surface, 2]
    near = surface[(run.held[surface] == PLATEN) | (gap <= fill if fill > 0.0 else False)]
    return np.sort(near).astype(np.int64)


def bonded_by_contact(
    sample: SampleMesh,
    preload: float,
    settings: BondSettings,
    alpha: Sequence[float],
    poisson_ratio: float,
    contact: ContactSettings,
    solver: SolverSettings,
    region_stiffness: Mapping[int | str, float] | None = None,
) -> SampleMesh:
    """The sample with what its pre-load touches as `glued`; arguments as of `touched_nodes`.

    `region_stiffness` has the relative stiffness of labelled regions.

    Raises
    ------
    InputError
        If the platen touches nothing.
    """
    fill = settings.fill_mm * MM
    region = sample.cell_data.get("region")
    stiffness = None if region is None else relative_stiffness(region, region_stiffness or {})
    law = alpha, poisson_ratio
    ids = touched_nodes(sample.mesh, preload, fill, *law, contact, solver, stiffness)
    if len(ids) == 0:
        raise InputError(
            f"protocol: preload_mm: a platen that goes {preload / MM:g} mm touches no node of the "
            "mesh; raise it, or choose bond: rule: within_depth"
        )
    glued = np.zeros(len(sample.mesh.points), dtype=np.uint8)
    glued[ids] = 1
    return replace(sample, point_data={**sample.point_data, "glued": glued})
