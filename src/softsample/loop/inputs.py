"""What runs of changed models start from, of what the files of the workflow hold."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.calibration.measured import MeasuredCurve
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.hexahedral import MeshSettings
from softsample.meshing.marks import MarkedImage
from softsample.meshing.mesh import HexMesh
from softsample.meshing.regions import relative_stiffness
from softsample.meshing.sample import SampleMesh, mesh_ideal, mesh_real
from softsample.shapes import IdealShape

Array = NDArray[np.float64]

MM = 1e-3


@dataclass(frozen=True)
class VariantSettings:
    """Steps of the changed models; mirrors config `loop: variants:`.

    Parameters
    ----------
    exponent : float
        Step of each exponent.
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

    exponent: float = 2.0
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
        `tension`, `compression` or `shear`.
    material : OgdenMaterial
        Two-term material at the optimum; its modulus only sets the scale.
    travel : float
        Travel of the record [m].
    contact, solver, variants
        As of the config.
    """

    mode: str
    material: OgdenMaterial
    travel: float
    contact: ContactSettings
    solver: SolverSettings
    variants: VariantSettings

    @classmethod
    def of(cls, fit: Mapping[str, Any], record: pd.DataFrame, given: Mapping[str, Any]) -> Self:
        """From a calibration, a record, and `mode`, `contact`, `solver`, `variants` of the job."""
        return cls(
            given["mode"],
            OgdenMaterial.of_fit(fit),
            MeasuredCurve.of_record(record, given["mode"]).travel,
            ContactSettings(**given["contact"]),
            SolverSettings(**given["solver"]),
            VariantSettings(**given["variants"]),
        )


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
    glued: NDArray[np.int64]
    stiffness: Array | None = None

    @classmethod
    def of(cls, made: SampleMesh, known: Mapping[int | str, float] | None = None) -> Self:
        """From a mesh, and the relative stiffness of its regions by their label."""
        region = made.cell_data.get("region")
        stiffness = None if region is None else relative_stiffness(region, known or {})
        return cls(made.mesh, np.flatnonzero(made.point_data["glued"]), stiffness)

    def model(self, solver: SolverSettings) -> ExplicitModel:
        """Model of it."""
        return ExplicitModel(self.mesh, solver, self.stiffness)


def mesher(
    geometry: str,
    grid: tuple[Array, Array, float],
    cuboid: Mapping[str, Any],
    marks: Mapping[str, MarkedImage],
    given: Mapping[str, Any],
) -> Callable[[float], MeshedSample]:
    """Meshes a sample with its surface moved out by a length [m].

    Parameters
    ----------
    geometry : str
        `real` or `ideal`.
    grid : tuple
        Its signed distance, where its origin is [m], and its spacing [m].
    cuboid : mapping
        Report of the idealised shape, ``cuboid/{sample}.json``.
    marks : mapping
        `bond_mask` and `labels` of the real geometry, if there are any.
    given : mapping
        `mesh`, `preload_mm`, `element_size_mm` and `region_stiffness` of the job.
    """
    size = given["element_size_mm"] * MM
    if geometry == "ideal":
        shape = IdealShape.of_report(cuboid)
        return lambda out: MeshedSample.of(mesh_ideal(shape.grown(out), size))
    segmented = given["mesh"]["boundary_shift_mm"] * MM
    return lambda out: MeshedSample.of(
        mesh_real(
            *grid,
            size,
            given["preload_mm"] * MM,
            MeshSettings.of_config(given["mesh"]),
            boundary_shift=segmented + out,
            bond_mask=marks.get("bond_mask"),
            labels=marks.get("labels"),
        ),
        given["region_stiffness"],
    )
