"""One test with the calibrated material: curve, deformed shape, energies, contact."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.arrays import Array
from softsample.constitutive.homogeneous import principal_stretches
from softsample.constitutive.material import Material
from softsample.errors import CrushedError
from softsample.fem.boundary import Ends
from softsample.fem.explicit import ExplicitModel
from softsample.fem.fields import CONTACT, contact_report, principal_hencky_strains
from softsample.fem.setup import Sample, set_up
from softsample.meshing.mesh import HexMesh
from softsample.response.curves import Curves
from softsample.response.unit import (
    CLOSED_FORM,
    Progress,
    homogeneous_area,
    run_report,
    shortest_loading_time,
)
from softsample.shapes import IdealShape

SNAPSHOTS = tuple(np.linspace(0.05, 1.0, 20))
"""Parts of the displacement at which contact is recorded."""

PATIENT = 4.0
"""Loading time of a run whose response is a closed form, over the shortest one."""


@dataclass(frozen=True)
class Optimum:
    """A test along its displacement.

    Parameters
    ----------
    displacement, force : (n,) float64
        Displacement of the platen [m] and force along it [N].
    field : (n_nodes, 3) float64
        Nodal displacements at the end [m].
    held : (n_nodes,) int8
        What holds each node at the end.
    energies : dict of (m,) float64
        `displacement` [m] and energies [J] along the way.
    contact : DataFrame
        `displacement` [m] and the numbers of `contact_report`.
    report : dict
        By what the run is judged.
    """

    displacement: Array
    force: Array
    field: Array
    held: NDArray[np.int8]
    energies: dict[str, Array]
    contact: pd.DataFrame
    report: dict[str, Any]

    def tables(self, sign: float) -> dict[str, pd.DataFrame]:
        """`curve`, `energies` and `contact` along `displacement_mm`, in the signs of the record."""
        energies = {f"{k}_J": values for k, values in self.energies.items() if k != "displacement"}
        contact = self.contact.drop(columns="displacement")
        contact.insert(0, "displacement_mm", sign * 1e3 * self.contact["displacement"])
        return {
            "curve": pd.DataFrame(
                {"displacement_mm": sign * 1e3 * self.displacement, "force_N": sign * self.force}
            ),
            "energies": pd.DataFrame(
                {"displacement_mm": sign * 1e3 * self.energies["displacement"], **energies}
            ),
            "contact": contact,
        }

    def difference_percent(self, curves: Curves, material: Material) -> float:
        """Largest difference from the force of unit-modulus curves [% of its peak]."""
        law = material.shear_modulus, material.mu1_fraction
        modelled = curves.force(self.displacement, *law)
        return float(100.0 * np.abs(self.force - modelled).max() / np.abs(modelled).max())

    def fields(
        self, mesh: HexMesh, point_data: Mapping[str, NDArray[Any]]
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Node data, with what the mesh has, and element data at the end."""
        of_nodes = {"displacement_mm": 1e3 * self.field, "held": self.held, **point_data}
        largest = principal_hencky_strains(mesh, self.field)[:, -1]
        return of_nodes, {"max_principal_hencky_strain": largest}


def loading_time(report: Mapping[str, Any], model: ExplicitModel) -> float:
    """Loading time of a response, from its report; a patient one if it is a closed form [s]."""
    return float(report.get("loading_time_s") or PATIENT * shortest_loading_time(model))


def optimum(
    sample: Sample,
    shape: IdealShape,
    test: tuple[str, Mapping[str, Any], Ends],
    material: Material,
    travel: float,
    response: Mapping[str, Any],
    progress: Progress,
) -> Optimum:
    """The test of a sample, by the solver or in closed form.

    Parameters
    ----------
    sample : tuple
        Mesh with its data.
    test : tuple
        Mode, sections of the config and ends, as of `softsample.fem.setup.set_up`.
    material : Material
        With the calibrated parameters.
    travel : float
        Displacement of the platen [m].
    response : mapping
        Report of the unit-modulus response.
    progress : callable
        Told what runs and the finished part.
    """
    mode, sections, ends = test
    points = sections["solver"]["curve_points"]
    homogeneous = partial(homogeneous_optimum, sample[0], shape, mode, material, travel, points)
    if mode == "shear" and ends == "sliding":
        return homogeneous()
    model, boundary = set_up(sample, *test)
    duration, told = loading_time(response, model), partial(progress, "run at the optimum")
    try:
        run = model.run(
            material, boundary, travel, snapshots=SNAPSHOTS, loading_time=duration, progress=told
        )
    except CrushedError:
        if response["method"] != CLOSED_FORM:
            raise
        return homogeneous(crushed=1)
    contact = [
        {"displacement": state.travel, **contact_report(model.mesh, state)}
        for state in run.snapshots
    ]
    found = run.displacement, run.force, run.displacement_field, run.held, run.energies
    return Optimum(*found, pd.DataFrame(contact), run_report(run))


def homogeneous_optimum(
    mesh: HexMesh,
    shape: IdealShape,
    mode: str,
    material: Material,
    travel: float,
    points: int,
    crushed: int = 0,
) -> Optimum:
    """A homogeneous test in closed form: simple shear, which no run of the solver is, or any other.

    Parameters
    ----------
    mesh, shape
        The ideal shape, on z = 0 and centred about the z axis.
    mode, material
        Of the test, and its law.
    travel : float
        Displacement of the platen [m].
    points : int
        Evenly spaced displacements, zero not counted.
    crushed : int
        Number of runs in whose place it stands, as they crushed elements.
    """
    displacement = np.linspace(0.0, travel, points + 1)
    area = homogeneous_area(shape, mode, displacement, material)
    force = material.shear_modulus * area
    strain = travel / shape.height
    stretches = principal_stretches(mode, strain, material)
    if mode == "shear":
        field = np.zeros_like(mesh.points)
        field[:, 0] = strain * mesh.points[:, 2]
        field[:, 1] = (stretches[1] - 1.0) * mesh.points[:, 1]
    else:
        field = (stretches - 1.0) * mesh.points
    steps = 0.5 * (force[1:] + force[:-1]) * np.diff(displacement)
    work = np.concatenate([[0.0], np.cumsum(steps)])
    none = np.zeros_like(work)
    return Optimum(
        displacement,
        force,
        field,
        np.zeros(len(mesh.points), np.int8),
        {
            "displacement": displacement, "strain": work, "hourglass": none, "kinetic": none,
            "work": work,
        },
        pd.DataFrame(columns=["displacement", *CONTACT]),
        {
            "method": CLOSED_FORM, "steps": 0, "energy_imbalance": 0.0, "hourglass_ratio": 0.0,
            "platen_against_base_percent": 0.0, "crushed_runs": crushed,
        },
    )  # fmt: skip
