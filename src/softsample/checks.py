"""Are the results sound: each check is a value, its limit, and whether it holds."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from softsample.errors import SimulationError
from softsample.fem.element import hex_geometry, lumped_mass
from softsample.meshing.mesh import HexMesh
from softsample.meshing.quality import element_volumes

Report = Mapping[str, Any]

LARGEST_IMBALANCE = 0.001
"""Largest |work - energy| over work of a run, in parts: more is lost by a time step that is too
long, or a fault of the solver."""

LARGEST_MASS_DIFFERENCE = 0.01
"""Largest difference of lumped mass and density times volume [%]: both are exact, so that rounding
alone may part them."""


def check(
    name: str, value: float, limit: float, sense: str = "<=", warn_above: float = np.inf
) -> dict[str, Any]:
    """One check: `value` against `limit`; `sense` is `<=` or `==`. NaN never passes.

    A value above `warn_above` passes with a warning.
    """
    holds = value == limit if sense == "==" else value <= limit
    return {
        "name": name,
        "value": float(value),
        "sense": sense,
        "limit": float(limit),
        "passed": bool(holds),
        "warned": bool(value > warn_above),
    }


def _largest(values: Iterable[float]) -> float:
    """Largest value; NaN if any is, which Python's `max` may overlook."""
    return float(np.max(list(values)))


def mass_difference_percent(mesh: HexMesh) -> float:
    """Lumped mass of the solver against density times the exact volume of the elements [%]."""
    density = 1000.0
    lumped = float(np.sum(lumped_mass(mesh, hex_geometry(mesh), density)))
    return 100.0 * abs(lumped / (density * float(np.sum(element_volumes(mesh)))) - 1.0)


def simulation_checks(
    mesh: HexMesh, quality: Report, families: Sequence[Report], direct: Report, limits: Report
) -> list[dict[str, Any]]:
    """Checks of one sample on one geometry.

    Parameters
    ----------
    mesh
        The mesh that was simulated.
    quality
        Its quality report.
    families
        Reports of its unit-modulus curves, one a material model; a closed form has no runs, so
        that the run at the optimum compares finite elements with it.
    direct
        Report of the run at the optimum.
    limits
        Config section `checks`.

    Returns
    -------
    list of dict
        `name`, `value`, `sense`, `limit`, `passed`.
    """
    runs = [*(run for family in families for run in family.get("runs", [])), direct]
    bounds = [family["error_bound_percent"] for family in families if family.get("runs")]
    found = [
        check(
            "volume of the mesh against the geometry [%]",
            abs(quality["volume_difference_percent"]),
            limits["volume_difference_percent_max"],
        ),
        check(
            "lumped mass against density times volume [%]",
            mass_difference_percent(mesh),
            LARGEST_MASS_DIFFERENCE,
        ),
        check(
            "energy imbalance over work",
            _largest(abs(run["energy_imbalance"]) for run in runs),
            LARGEST_IMBALANCE,
        ),
        check(
            "hourglass over strain energy",
            _largest(run["hourglass_ratio"] for run in runs),
            limits["hourglass_ratio_max"],
            warn_above=limits["hourglass_ratio_warning"],
        ),
        check(
            "platen against base force [% of peak]",
            _largest(run["platen_against_base_percent"] for run in runs),
            limits["platen_against_base_percent_max"],
        ),
    ]
    if bounds:
        most = limits["error_bound_percent_max"]
        found.append(check("error of the finite loading time [% of peak]", _largest(bounds), most))
    apart, most = (
        direct["against_calibrated_curve_percent"],
        limits["direct_difference_percent_max"],
    )
    found.append(check("direct run against calibrated curve [% of peak]", apart, most))
    if crushed := direct.get("crushed_runs", 0):
        found.append(check("runs at the optimum that crushed elements", crushed, 0, "=="))
    return found


def calibration_checks(fits: Iterable[Report]) -> list[dict[str, Any]]:
    """Checks of every calibration of one group: that it converged."""
    return [
        check(f"optimiser converged ({_fitted(fit)})", float(fit["converged"]), 1.0, "==")
        for fit in fits
    ]


def calibration_findings(fits: Iterable[Report]) -> list[str]:
    """What calibrations that ended on a bound say of their data: a finding, not a fault.

    A model that cannot follow the record with admissible moduli (mu_i >= 0) ends there.
    """
    return [f"{_fitted(fit)}: {fit['finding']}" for fit in fits if fit["finding"]]


def _fitted(fit: Report) -> str:
    """Geometry and model of a calibration."""
    return f"{fit['geometry']}, {fit['model']}"


def checked(checks: Sequence[Report], findings: Sequence[str] = ()) -> dict[str, Any]:
    """Report of some checks: whether all `passed`, `checks`, and `findings` to look at."""
    passed = all(item["passed"] for item in checks)
    return {"passed": passed, "checks": checks, "findings": findings}


def gather(reports: Mapping[str, Report]) -> dict[str, Any]:
    """Number of checks and the tightest value of each, if all of them passed; what to look at.

    Parameters
    ----------
    reports
        Reports (`checked`) by name of what was checked.

    Raises
    ------
    SimulationError
        Naming every check that failed, with value and limit, and what calibrations found.
    """
    found = [f"{at}: {told}" for at, report in reports.items() for told in report["findings"]]
    every = [(where, item) for where, report in reports.items() for item in report["checks"]]
    failed = [
        f"  {where}: {item['name']} is {item['value']:.4g}, must be {item['sense']} "
        f"{item['limit']:.4g}"
        for where, item in every
        if not item["passed"]
    ]
    if failed:
        head = (
            f"{len(failed)} of {len(every)} checks failed; look at these results before "
            "using any number, then change the mesh, solver or limits in the config:"
        )
        raise SimulationError("\n".join([head, *failed, *(f"  {told}" for told in found)]))
    worst: dict[str, float] = {}
    for _, item in every:
        worst[item["name"]] = max(worst.get(item["name"], item["value"]), item["value"])
    warnings = [
        f"{where}: {item['name']} is {item['value']:.4g}" for where, item in every if item["warned"]
    ]
    warnings += found
    return {"passed": True, "checks": len(every), "worst": worst, "warnings": warnings}
