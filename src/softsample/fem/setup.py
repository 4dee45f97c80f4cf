"""From the files of one sample to a model and what holds it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsample.fem.boundary import BONDED, Boundary, ContactSettings, Ends, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.mesh import HexMesh
from softsample.meshing.regions import relative_stiffness

Section = Mapping[str, Any]


def set_up(
    mesh: HexMesh,
    point_data: Mapping[str, NDArray],
    cell_data: Mapping[str, NDArray],
    mode: str,
    *,
    solver: Section,
    contact: Section,
    material: Section,
    ends: Ends = BONDED,
) -> tuple[ExplicitModel, Boundary]:
    """Model and boundary conditions of one test.

    Parameters
    ----------
    mesh : HexMesh
        The sample [m].
    point_data : mapping
        Flag `glued` (n_nodes,) of the nodes that the moving platen is glued to.
    cell_data : mapping
        `region` (n_elements,), the labels of regions of different stiffness, where there are any.
    mode : str
        One of `softsample.protocol.DIRECTIONS`.
    solver, contact, material : mapping
        Sections of the config.
    ends : str or float
        What the ends of the sample do on the platens, see `mode_boundary`.

    Raises
    ------
    InputError
        If a region has no stiffness in ``material: region_stiffness``, or the mode cannot be
        tested with such ends.
    MeshError
        If an element has no positive volume.
    """
    stiffness = (
        relative_stiffness(cell_data["region"], material["region_stiffness"])
        if "region" in cell_data
        else None
    )
    model = ExplicitModel(mesh, SolverSettings(**solver), stiffness)
    glued = np.flatnonzero(point_data["glued"])
    return model, mode_boundary(mesh, mode, glued, ContactSettings(**contact), ends)
