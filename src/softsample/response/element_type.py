"""Forces of another type of element against ours, on the same mesh."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.arrays import Ids
from softsample.constitutive.material import Material
from softsample.fem.boundary import ContactSettings, glued_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, Run, SolverSettings
from softsample.meshing.mesh import HexMesh
from softsample.protocol import travel_sign
from softsample.response.unit import find_pace


@dataclass(frozen=True, eq=False)
class OtherElement:
    """A test that another program ran with three-field elements.

    Parameters
    ----------
    mode : str
        `shear`, glued on either end, or `compression` by a platen without slip.
    mesh : HexMesh
    top : (n,) int64
        Nodes that are glued to the platen.
    travel, force : float
        Displacement of the platen at the end [m], and force along it [N].
    """

    mode: str
    mesh: HexMesh
    top: Ids
    travel: float
    force: float

    @classmethod
    def of_reference(cls, mode: str, mesh: Mapping[str, NDArray[Any]], curve: pd.DataFrame) -> Self:
        """From `nodes_mm`, `hex8` and `top` of a mesh, and `ux_mm`, `Fx_N` ... of its curve."""
        axis, sign = "x" if mode == "shear" else "z", travel_sign(mode)
        last = curve.iloc[-1]
        return cls(
            mode,
            HexMesh(1e-3 * mesh["nodes_mm"], mesh["hex8"].astype(np.int64)),
            mesh["top"].astype(np.int64),
            sign * 1e-3 * float(last[f"u{axis}_mm"]),
            sign * float(last[f"F{axis}_N"]),
        )

    def against_one_point(self, solver: SolverSettings, material: Material) -> dict[str, Any]:
        """The same test by our elements: `mode`, `edge_mm`, `elements`, force of either at the end.

        `three_field_over_one_point_percent`: by how much theirs is larger.
        """
        if self.mode == "shear":
            boundary = glued_boundary(self.mesh, self.mode, self.top)
        else:
            free = ContactSettings(release=False, side_walls=False, base_platen=False)
            boundary = platen_boundary(self.mesh, free)
        model = ExplicitModel(self.mesh, solver)

        def loaded(duration: float) -> Run:
            return model.run(material, boundary, self.travel, loading_time=duration)

        pace = find_pace(loaded, solver.loading_time_s, solver.curve_error_percent)
        own = pace.run.force[-1]
        return {
            "mode": self.mode,
            "edge_mm": 1e3 * self.mesh.edge_length,
            "elements": len(self.mesh.hexes),
            "one_point_N": own,
            "three_field_N": self.force,
            "three_field_over_one_point_percent": 100.0 * (self.force / own - 1.0),
        }
