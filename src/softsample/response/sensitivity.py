"""Numerical choices whose effect on a curve every study measures."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from softsample.arrays import Array
from softsample.constitutive.material import Material
from softsample.fem.boundary import Ends
from softsample.fem.setup import Sample, set_up
from softsample.response.optimum import loading_time
from softsample.response.unit import CLOSED_FORM, Progress, curve_difference

STIFFER, COARSE = "twice the hourglass stiffness", "elements of twice the size"
"""Names of the changes. Half the hourglass stiffness changes less than twice in all fifteen samples
of the study, and double precision less than 0.001 %."""


def numerical_changes(hourglass_coefficient: float) -> dict[str, tuple[str, dict[str, Any]]]:
    """By name of each change: which mesh, `mesh` or `coarse`, and settings of the solver."""
    return {
        STIFFER: ("mesh", {"hourglass_coefficient": 2.0 * hourglass_coefficient}),
        COARSE: ("coarse", {}),
    }


def forces_with_changes(
    meshes: Mapping[str, Sample],
    test: tuple[str, Mapping[str, Any], Ends],
    material: Material,
    travel: float,
    response: Mapping[str, Any],
    reference: tuple[Array, Array],
    progress: Progress,
) -> dict[str, Array]:
    """Force (n,) [N] of the test with each change.

    Parameters
    ----------
    meshes : mapping of tuple
        The sample's mesh with its data, `mesh`, and one with elements of twice the size, `coarse`.
    test : tuple
        Mode, sections of the config and ends, as of `softsample.fem.setup.set_up`.
    material : Material
        At the optimum.
    travel : float
        Displacement of the platen [m].
    response : mapping
        Report of the unit-modulus response.
    reference : tuple of (n,) float64
        Displacements [m] that are asked for, and the force without a change [N].
    progress : callable
        Told the change and the finished part.
    """
    mode, sections, ends = test
    changes = numerical_changes(sections["solver"]["hourglass_coefficient"])
    displacement, force = reference
    forces = dict.fromkeys(changes, force)
    if response["method"] == CLOSED_FORM:  # which has no mesh, and nothing to choose
        return forces
    for done, (name, (mesh, settings)) in enumerate(changes.items()):
        progress(name, done / len(changes))
        solver = {**sections["solver"], **settings}
        changed = {part: sections[part] for part in ("contact", "material")} | {"solver": solver}
        model, boundary = set_up(meshes[mesh], mode, changed, ends)
        run = model.run(material, boundary, travel, loading_time=loading_time(response, model))
        forces[name] = np.interp(displacement, run.displacement, run.force)
    return forces


def changes_of_force(
    forces: Mapping[str, Array], reference: Array, scale_of: Callable[[Array], float]
) -> dict[str, dict[str, float]]:
    """What each change does to a curve.

    Parameters
    ----------
    forces : mapping of (n,) float64
        Force [N] along the record by name of the change.
    reference : (n,) float64
        Without a change.
    scale_of : callable
        Factor that brings a force closest to the record: that of the calibrated modulus.

    Returns
    -------
    dict
        By name: `largest_percent_of_peak`, `end_force_percent`, `modulus_percent`.
    """
    return {
        name: {
            "largest_percent_of_peak": 100.0 * curve_difference(force, reference),
            "end_force_percent": 100.0 * float(force[-1] / reference[-1] - 1.0),
            "modulus_percent": 100.0 * (scale_of(force) / scale_of(reference) - 1.0),
        }
        for name, force in forces.items()
    }
