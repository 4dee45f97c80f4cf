"""Which nodes of the top a test bonds to the platen: by height, or by a simulated pre-load."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from softsample.arrays import Array, Ids
from softsample.constitutive.material import Material
from softsample.constitutive.ogden import unit_modulus
from softsample.errors import InputError, SoftsampleError
from softsample.fem.boundary import ContactSettings, mode_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.fem.motion import PLATEN
from softsample.fem.setup import Sample, set_up
from softsample.meshing.bond import bonded_area
from softsample.meshing.regions import stiffness_of
from softsample.meshing.sample import SampleMesh
from softsample.response.curves import Curves, Scaled
from softsample.response.unit import paced
from softsample.units import MM

LOG = logging.getLogger(__name__)

# ASSUME: the bond does not hang on how the modulus is split between the two terms.
EVEN = 0.5
"""Modulus fraction of the sample that a pre-load presses."""

POINTS = 60
"""Displacements at which the forces of two rules are compared."""

WITHIN_DEPTH, CONTACT = "within_depth", "contact"
"""Rules by which a top is bonded without a mask, see `BondSettings`."""


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

    rule: str = WITHIN_DEPTH
    fill_mm: float = 0.0


def touched_nodes(
    model: ExplicitModel,
    preload: float,
    fill: float,
    alpha: Sequence[float],
    poisson_ratio: float,
    contact: ContactSettings,
    loading_time: float | None = None,
) -> Ids:
    """Nodes of the surface that a flat, rough platen touches, or nearly, in the pre-load.

    The sample rests on its base, unloaded; the platen comes down from its highest point.

    Parameters
    ----------
    preload : float
        Way of the platen [m].
    fill : float
        Gap between surface and platen that counts as touched [m].
    alpha : sequence of float
        Exponents of the two terms of the sample's material, which has as much of each.
    poisson_ratio : float
        Of that material.
    contact : ContactSettings
        As of the config; nothing slips.
    loading_time : float, optional
        Time of the way [s]; by default the force is as exact as `curve_error_percent` asks.

    Returns
    -------
    (n,) int64
        Sorted ids.

    Raises
    ------
    SimulationError
        If the pre-load cannot be simulated.
    """
    mesh = model.mesh
    material = unit_modulus(EVEN, alpha, poisson_ratio, model.settings.reference_modulus_pa)
    boundary = platen_boundary(mesh, replace(contact, friction=None, base_friction=None))
    run = (
        model.run(material, boundary, preload, loading_time=loading_time)
        if loading_time
        else paced(model, material, boundary, preload).run
    )
    surface = mesh.boundary
    gap = mesh.highest - preload - (mesh.points + run.displacement_field)[surface, 2]
    near = surface[(run.held[surface] == PLATEN) | (gap <= fill if fill > 0.0 else False)]
    return np.sort(near).astype(np.int64)


def by_rule(
    sample: Sample,
    mode: str,
    material: Material,
    furthest: float,
    loading_time: float,
    preload: float,
    settings: BondSettings,
    sections: Mapping[str, Any],
) -> dict[str, Any]:
    """What either rule makes of a test.

    Parameters
    ----------
    sample : tuple
        Mesh [m], node data and element data of the sample.
    mode : str
        Of the test, glued on either platen.
    material : Material
        At the optimum.
    furthest : float
        Displacement of the platen at the end of loading [m].
    loading_time : float
        Of the response [s]; the pre-load takes as long. Ten times as long, the area changes by
        0.5 %.
    preload : float
        Way of the platen [m].
    settings : BondSettings
        The study's; `fill_mm` is that of `contact`.
    sections : mapping
        Of the config: `material`, `contact`, `solver`; and `ends`, as of `set_up`.

    Returns
    -------
    dict
        `rule`: the study's; `{rule}_mm2`: bonded area projected on the base, of whole faces;
        `displacement_mm` and `force_ratio`: force with the rule `contact` over that with
        `within_depth`; `force_percent`: by how much more work it does in loading. None is what
        cannot be simulated.
    """
    mesh = sample[0]
    model, _ = set_up(sample, mode, sections, sections["ends"])
    law, platen = sections["material"], ContactSettings(**sections["contact"])
    pressed = preload, settings.fill_mm * MM, law["alpha"], law["poisson_ratio"], platen
    displacement = np.linspace(0.0, furthest, POINTS + 1)[1:]

    def of_bond(ids: Ids) -> Array:
        boundary = mode_boundary(mesh, mode, ids, platen, sections["ends"])
        run = model.run(material, boundary, furthest, loading_time=loading_time)
        return np.interp(displacement, run.displacement, run.force)

    bonded, ratio, percent = {WITHIN_DEPTH: mesh.glued(preload)}, None, None
    try:
        bonded[CONTACT] = touched_nodes(model, *pressed, loading_time)
        forces = {rule: of_bond(ids) for rule, ids in bonded.items()}
        ratio = forces[CONTACT] / forces[WITHIN_DEPTH]
        percent = 100.0 * float(forces[CONTACT].sum() / forces[WITHIN_DEPTH].sum() - 1.0)
    except SoftsampleError as error:
        LOG.warning("rules of the bond cannot be compared: %s", error)
    area = {rule: 1e6 * float(bonded_area(mesh, ids).sum()) for rule, ids in bonded.items()}
    return {
        "rule": settings.rule,
        **{f"{rule}_mm2": area.get(rule) for rule in (WITHIN_DEPTH, CONTACT)},
        "displacement_mm": (displacement / MM).tolist(),
        "force_ratio": None if ratio is None else ratio.tolist(),
        "force_percent": percent,
    }


def of_other_rule(curves: Curves, report: Mapping[str, Any]) -> Scaled:
    """Curves of a sample as if the other rule than the study's had bonded it.

    The ratio of forces of `report`, which `by_rule` returns, is that of the calibrated material; it
    is taken to hold at every modulus fraction.
    """
    ratio = np.array(report["force_ratio"])
    other = ratio if report["rule"] == WITHIN_DEPTH else 1.0 / ratio
    return Scaled(curves, other, MM * np.array(report["displacement_mm"]))


def log_force(report: Mapping[str, Any]) -> float:
    """Log of the force of the other rule over that of the study's; NaN if it is not known.

    `report` is `by_rule`.
    """
    if report["force_percent"] is None:
        return float("nan")
    change = float(np.log1p(0.01 * report["force_percent"]))
    return change if report["rule"] == WITHIN_DEPTH else -change


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
    stiffness = stiffness_of(sample.cell_data, region_stiffness)
    model = ExplicitModel(sample.mesh, solver, stiffness)
    ids = touched_nodes(model, preload, fill, alpha, poisson_ratio, contact)
    if len(ids) == 0:
        raise InputError(
            f"protocol: preload_mm: a platen that goes {preload / MM:g} mm touches no node of the "
            "mesh; raise it, or choose bond: rule: within_depth"
        )
    glued = np.zeros(len(sample.mesh.points), dtype=np.uint8)
    glued[ids] = 1
    return replace(sample, point_data={**sample.point_data, "glued": glued})
