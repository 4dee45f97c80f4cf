"""Confirmation: the best effects, run in the solver at the sizes that were found.

A verdict scales the change of one run per effect linearly, or takes a law between runs. Here the
changed model itself is run, its force takes its place, and the material is fitted again.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from softsample.loop.discrepancy import settled
from softsample.loop.effects import library
from softsample.loop.effects.base import Effect, Values
from softsample.loop.fit import Fit, Problem
from softsample.loop.model import Model
from softsample.loop.posed import LoopSettings, pose
from softsample.loop.screen import penalty
from softsample.loop.specimen import KINDS, Array, Specimen
from softsample.response.at_size import at_size

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


def of_mode(sizes: Sizes, mode: str) -> Sizes:
    """Those of effects that act in a mode."""
    kind = KINDS.get(mode, mode)
    return {name: values for name, values in sizes.items() if kind in library()[name].modes}


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


def _simulated(name: str) -> Callable[[Specimen, float, Array, Values], Array]:
    return lambda specimen, fraction, travel, values: specimen.elastic.change_per_mu(
        at_size(name), fraction, travel
    )


def _fitted(problem: Problem, effect: Effect, start: Fit, values: Values) -> Fit:
    """Joint fit of material and one effect from some sizes."""
    return problem.fit(Model((effect,)), replace(start.state, values={effect.name: values}))
