"""From the files of one sample to a model and what holds it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsample.fem.boundary import BONDED, Boundary, ContactSettings, Ends, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.mesh import HexMesh
from softsample.meshing.regions import stiffness_of

Sample = tuple[HexMesh, Mapping[str, NDArray[Any]], Mapping[str, NDArray[Any]]]
"""Mesh [m], node data and element data, as `softsample.io.read_mesh_with_data` returns them."""


def set_up(
    sample: Sample, mode: str, sections: Mapping[str, Any], ends: Ends = BONDED
) -> tuple[ExplicitModel, Boundary]:
    """Model and boundary conditions of one test.

    Parameters
    ----------
    sample : tuple
        Its mesh; flag `glued` (n_nodes,) of the nodes that the moving platen is glued to; `region`
        (n_elements,), the labels of regions of different stiffness, where there are any.
    mode : str
        One of `softsample.protocol.DIRECTIONS`.
    sections : mapping
        Sections `solver`, `contact` and `material` of the config.
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
    mesh, point_data, cell_data = sample
    stiffness = stiffness_of(cell_data, sections["material"].get("region_stiffness"))
    model = ExplicitModel(mesh, SolverSettings(**sections["solver"]), stiffness)
    glued = np.flatnonzero(point_data["glued"])
    contact = ContactSettings(**sections["contact"])
    return model, mode_boundary(mesh, mode, glued, contact, ends)
