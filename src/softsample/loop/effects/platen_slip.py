"""The sample slips on the moving platen instead of sticking: compression."""

from functools import partial

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values

LOOP = "_loop"
"""Ends the names of runs with friction that come back: what their force is more on that way."""


def _elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    slip = specimen.elastic.change_per_mu("platen_slip", fraction, travel)
    return values["share"] * slip + _loop(specimen, fraction, travel, values["share"])


def _loop(specimen: Specimen, fraction: float, travel: Array, share: float) -> Array:
    """Change (n,) [m2] from loading to unloading.

    Between the runs, sticking, with more or less friction, and without, it is linear in the share
    of the slip: a sample that sticks does not rub, and sliding without friction costs nothing. The
    runs turn where the family ends; elsewhere a loop is the same part of the force at the turn, at
    the same part of the way.
    """
    elastic = specimen.elastic
    runs = [name for name in elastic.perturbations if name.endswith(LOOP)]
    if not runs or not share:
        return np.zeros_like(travel)
    change, end = (
        partial(elastic.change_per_mu, fraction=fraction),
        elastic.curves.displacement[-1:],
    )
    free = change("platen_slip", displacement=end).item()
    shares = {run: change(run.removesuffix(LOOP), displacement=end).item() / free for run in runs}
    runs.sort(key=lambda run: shares[run])
    corners = [0.0, *np.clip([shares[run] for run in runs], 0.01, 0.99), 1.0]
    turn = np.maximum.accumulate(np.maximum(travel, 1e-3 * end))
    way = travel / turn
    loop = np.zeros_like(travel)
    for run, weights in zip(runs, np.eye(len(corners))[1:-1], strict=True):
        size = np.interp(share, corners, weights)
        if size:
            at_turn = change(run, displacement=end)  # what smoothing leaves there
            loop += size * (change(run, displacement=end * way) - way * at_turn)
    force_at_turn, force_at_end = (elastic.force_per_mu(fraction, x) for x in (turn, end))
    return np.where(specimen.phase == "ramp", 0.0, loop * force_at_turn / force_at_end)


EFFECT = Effect(
    name="platen_slip",
    title="Slip on the platen",
    parameters=(Parameter("share", "1", 0.0, 1.0, 0.3),),
    source="Rashid, Destrade, Gilchrist, J. Mech. Behav. Biomed. Mater. 12 (2012); own runs",
    signature="compression softer, increasingly along the stroke; unloading below loading",
    confused_with=("tension_compression_asymmetry", "poisson_ratio", "partial_bond"),
    experiment="marks on the edge of the top; bond the compression sample",
    modes=("compression",),
    elastic=_elastic,
)
