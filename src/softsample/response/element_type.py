"""Forces of another type of element against ours, on the same mesh."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.constitutive.material import Material
from softsample.fem.boundary import ContactSettings, glued_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, Run, SolverSettings
from softsample.meshing.mesh import HexMesh
from softsample.protocol import travel_sign
from softsample.response.unit import find_pace


def against_one_point(
    mode: str,
    reference: Mapping[str, NDArray[Any]],
    curve: pd.DataFrame,
    solver: SolverSettings,
    material: Material,
) -> dict[str, Any]:
    """A test that another program ran with three-field elements, by ours.

    Parameters
    ----------
    mode : str
        `shear`, glued on either end, or `compression` by a platen without slip.
    reference : mapping
        `nodes_mm`, `hex8` and `top` of its mesh, the nodes that are glued to the platen.
    curve : DataFrame
        `ux_mm`, `Fx_N` ... of the platen; its end counts.

    Returns
    -------
    dict
        `mode`, `edge_mm`, `elements`, force of either at the end, and
        `three_field_over_one_point_percent`: by how much theirs is larger.
    """
    mesh = HexMesh(1e-3 * reference["nodes_mm"], reference["hex8"].astype(np.int64))
    axis, sign, last = "x" if mode == "shear" else "z", travel_sign(mode), curve.iloc[-1]
    travel, force = sign * 1e-3 * float(last[f"u{axis}_mm"]), sign * float(last[f"F{axis}_N"])
    if mode == "shear":
        boundary = glued_boundary(mesh, mode, reference["top"].astype(np.int64))
    else:
        free = ContactSettings(release=False, side_walls=False, base_platen=False)
        boundary = platen_boundary(mesh, free)
    model = ExplicitModel(mesh, solver)

    def loaded(duration: float) -> Run:
        return model.run(material, boundary, travel, loading_time=duration)

    own = find_pace(loaded, solver.loading_time_s, solver.curve_error_percent).run.force[-1]
    return {
        "mode": mode,
        "edge_mm": 1e3 * mesh.edge_length,
        "elements": len(mesh.hexes),
        "one_point_N": own,
        "three_field_N": force,
        "three_field_over_one_point_percent": 100.0 * (force / own - 1.0),
    }
