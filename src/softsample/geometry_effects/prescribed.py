"""Compression by prescribed displacements of the top nodes in place of contact with a platen."""

import logging
from collections.abc import Callable

import numpy as np
import pandas as pd

from softsample.constitutive.material import Material
from softsample.errors import SimulationError
from softsample.fem.boundary import ContactSettings, glued_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, Run
from softsample.meshing.bond import top_quads

SHARES = (1.0, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7)
"""Parts of the travel that are tried, the largest first."""


def simulate_both(
    model: ExplicitModel,
    material: Material,
    travel: float,
    contact: ContactSettings,
    normal_deg: float,
    loading_time: float,
    progress: Callable[[float], None] | None = None,
) -> pd.DataFrame:
    """Force of the same compression by contact and by moving the top's nodes.

    Parameters
    ----------
    model, material
        Sample or cuboid, and what it is made of.
    travel
        Travel of the platen [m].
    contact
        Rules of contact.
    normal_deg
        The nodes that move are those of faces within this angle of vertical in the upper half.
    loading_time
        Solver time of the ramp [s].
    progress
        Told the finished part of each run.

    Returns
    -------
    DataFrame
        `displacement` [m], `contact`, `prescribed` [N], along the travel; they end before it
        where elements at the edge of the top invert.
    """
    top = np.unique(top_quads(model.mesh, normal_deg))
    boundaries = (
        platen_boundary(model.mesh, contact),
        glued_boundary(model.mesh, "compression", top),
    )
    contact_run, run = (
        as_far_as_it_goes(
            lambda way, held=held: model.run(  # type: ignore[misc]
                material, held, way, loading_time=loading_time, progress=progress
            ),
            travel,
        )
        for held in boundaries
    )
    return pd.DataFrame(
        {
            "displacement": run.displacement,
            "contact": np.interp(run.displacement, contact_run.displacement, contact_run.force),
            "prescribed": run.force,
        }
    )


def as_far_as_it_goes(simulate: Callable[[float], Run], travel: float) -> Run:
    """The run to the largest of some travels [m] that the mesh survives.

    Raises
    ------
    SimulationError
        If elements invert before 70 % of the travel.
    """
    for share in SHARES[:-1]:
        try:
            return simulate(share * travel)
        except SimulationError as error:
            logging.getLogger("prescribed").warning("stops before %.3g mm: %s", 1e3 * travel, error)
    return simulate(SHARES[-1] * travel)
