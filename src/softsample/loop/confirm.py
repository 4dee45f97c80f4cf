"""Confirmation: the best effects, run in the solver at the sizes that were found.

A verdict scales the change of one run per effect linearly, or takes a law between runs. Here the
changed model itself is run, its force takes its place, and the material is fitted again.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from softsample.constitutive.material import Material, Term
from softsample.constitutive.ogden import Fibres, OgdenMaterial
from softsample.fem.boundary import Boundary, platen_boundary
from softsample.loop.discrepancy import settled
from softsample.loop.effects import library
from softsample.loop.effects.base import Effect, Values
from softsample.loop.fit import Fit, Problem
from softsample.loop.model import Model
from softsample.loop.posed import LoopSettings, pose
from softsample.loop.screen import penalty
from softsample.loop.specimen import KINDS, Array, Specimen
from softsample.response.perturbations import MARGIN, changed_boundaries, paced
from softsample.response.pieces import MechanicalTest, MeshedSample

Runs = list[tuple[float, Material, Boundary]]
Sizes = Mapping[str, Values]

MOST = 3
"""Effects that are confirmed."""

SIMULATED = (
    "poisson_ratio", "elastic_law", "ogden_exponents", "compressible_foam", "anisotropy",
    "boundary_shift", "partial_bond", "platen_tilt",
)  # fmt: skip
"""Effects whose sizes are those of a model. Slip is a share of a run that there is already."""

COLUMNS = (
    "effect", "sizes", "threshold", "evidence", "evidence_confirmed", "confirmed", "mu_pa",
    "mu_confirmed_pa", "difference_percent",
)  # fmt: skip


def sizes_to_confirm(verdict: Mapping[str, Any]) -> dict[str, Values]:
    """Sizes of the best effects of the first round that change the solver's model.

    None where open ends slide, since the runs have the study's bonded ones, and no fibres in a
    direction of the material that lies differently in each test.
    """
    if (verdict.get("other_ends") or {}).get("ends") == "bonded":
        return {}
    first = verdict["path"][0]["candidates"]
    best = [c for c in first if c["name"] in SIMULATED and c["evidence"] > 0.0]
    known = [c for c in best if "azimuth_deg" not in c["values"]]
    return {c["name"]: c["values"] for c in known[:MOST]}


def simulate_sizes(
    mesh_shifted: Callable[[float], MeshedSample], test: MechanicalTest, sizes: Sizes
) -> tuple[Array, dict[str, Array]]:
    """Change of the force per modulus by each effect at its size.

    Parameters
    ----------
    mesh_shifted : callable
        Meshes the sample with its surface moved out by a length [m].
    test : MechanicalTest
        What is done to it.
    sizes : mapping
        Values of the parameters by effect.

    Returns
    -------
    displacement : (n,) float64
        Travels [m].
    changes : dict of (n,) float64
        Change of the force along the travel per shear modulus [m2] by effect, of those alone that
        act in this mode.
    """
    material, reach = test.material, MARGIN * test.travel

    sample = mesh_shifted(0.0)
    model = sample.model(test.solver)
    held = test.held(sample)
    pace = paced(model, material, held, reach)
    changes = {}
    for name, values in sizes.items():
        if KINDS.get(test.mode, test.mode) not in library()[name].modes:
            continue
        if name == "boundary_shift":
            larger = mesh_shifted(1e-3 * values["shift_mm"])
            on = larger.model(test.solver)
            runs = [(1.0, material, test.held(larger))]
        else:
            on, runs = model, _runs(name, values, sample, test, held)
        change = sum(
            weight
            * (on.run(of, hold, reach, loading_time=pace.loading_time).force - pace.run.force)
            for weight, of, hold in runs
        )
        changes[name] = np.asarray(change / material.shear_modulus)
    return pace.run.displacement, changes


def _runs(
    name: str, values: Values, sample: MeshedSample, test: MechanicalTest, held: Boundary
) -> Runs:
    """Weights, materials and boundaries of the runs that make up an effect at its sizes."""
    material = test.material
    if name == "poisson_ratio":
        return [(1.0, replace(material, poisson_ratio=values["nu"]), held)]
    if name == "ogden_exponents":
        alpha = values["alpha1"], values["alpha2"]
        return [(1.0, OgdenMaterial(material.mu, alpha, material.poisson_ratio), held)]
    if name == "elastic_law":
        one = OgdenMaterial((material.shear_modulus,), (values["alpha"],), material.poisson_ratio)
        return [(values["share"], one, held)]
    if name == "compressible_foam":
        foam = Term("foam", material.shear_modulus, (values["alpha"], values["nu"]))
        return [(values["share"], Material((foam,), values["nu"]), held)]
    if name == "anisotropy":
        angle = np.radians(values["angle_deg"])
        along = float(np.sin(angle)), 0.0, float(np.cos(angle))
        fibres = Fibres(values["k1"] * material.shear_modulus, along)
        return [(1.0, material.plus(fibres), held)]
    if name == "platen_tilt":
        axis, tilt = np.radians(values["axis_deg"]), values["tilt_deg"]
        tilts = (float(tilt * np.cos(axis)), float(tilt * np.sin(axis)))
        return [(1.0, material, platen_boundary(sample.mesh, test.platen_contact, tilt_deg=tilts))]
    side, steps = values["side"], replace(test.steps, missing_bond=values["missing"])
    weights = {
        "partial_bond_ahead": max(side, 0.0),
        "partial_bond_behind": max(-side, 0.0),
        "partial_bond_beside": 1.0 - abs(side),
    }
    boundaries = changed_boundaries(sample, replace(test, steps=steps))
    return [
        (weight, material, boundaries[variant])
        for variant, weight in weights.items()
        if weight > 0.0 and variant in boundaries
    ]


def confirmations(
    specimens: Sequence[Specimen],
    sizes: Sizes,
    threshold: float,
    settings: LoopSettings,
    effects: Mapping[str, Effect],
    stiffness: Mapping[str, float],
    contact: Mapping[str, float],
) -> pd.DataFrame:
    """Evidence of effects whose change was scaled, and of the same ones simulated at their sizes.

    Parameters
    ----------
    specimens : sequence of Specimen
        Tests of a group. Their models have the simulated changes as variants named `at_size`
        and the effect, see `at_size`.
    sizes : mapping
        Values of the parameters by effect.
    threshold : float
        Evidence that the round of the selection asked for.
    settings : LoopSettings
        Those of the verdict.
    effects : mapping
        Library that it chose from.
    stiffness : mapping
        Modulus of specimens over that of the group, where the verdict has found that they scatter.
    contact : mapping
        Where their compression begins, over the mean [mm], in the same way.

    Returns
    -------
    DataFrame
        One row an effect: `sizes`; `threshold`; `evidence` and `evidence_confirmed`, less the
        penalty for the parameters; whether the latter passes; `mu_pa` and `mu_confirmed_pa`;
        `difference_percent`, the largest one of the predicted forces [% of the peak of the test].
    """
    own = [s.with_own(stiffness=stiffness, contact=contact) for s in specimens]
    problem, _ = pose(own, settings.noise)
    base = problem.fit_material()
    before, rows = settled(problem, base).misfit, []
    for name, values in sizes.items():
        effect = effects[name]
        scaled = _fitted(problem, effect, base, values)
        stand_in = replace(effect, parameters=(), elastic=_simulated(name))
        run = _fitted(problem, stand_in, scaled, {})
        same_material = replace(scaled.state, values={name: {}})
        apart = [
            np.abs(a - b).max() / np.abs(specimen.force).max()
            for a, b, specimen in zip(
                problem.predicted(scaled.model, scaled.state),
                problem.predicted(run.model, same_material),
                problem.specimens,
                strict=True,
            )
        ]
        evidence, confirmed = (
            before - settled(problem, fit).misfit - penalty(effect, len(base.white))
            for fit in (scaled, run)
        )
        rows.append(
            (
                name,
                "; ".join(f"{key} {value:.4g}" for key, value in values.items()),
                threshold,
                evidence,
                confirmed,
                bool(confirmed >= threshold),
                scaled.state.material.mu,
                run.state.material.mu,
                100.0 * max(apart),
            )
        )
    return pd.DataFrame(rows, columns=list(COLUMNS))


def at_size(name: str) -> str:
    """Name of the variant that is an effect simulated at its size."""
    return f"at_size_{name}"


def _simulated(name: str) -> Callable[[Specimen, float, Array, Values], Array]:
    return lambda specimen, fraction, travel, values: specimen.elastic.change_per_mu(
        at_size(name), fraction, travel
    )


def _fitted(problem: Problem, effect: Effect, start: Fit, values: Values) -> Fit:
    """Joint fit of material and one effect from some sizes."""
    return problem.fit(Model((effect,)), replace(start.state, values={effect.name: values}))
