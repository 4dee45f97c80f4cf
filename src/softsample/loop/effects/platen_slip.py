"""The sample slips on the moving platen instead of sticking: compression."""

from functools import partial

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, mixture: float, travel: Array, values: Values) -> Array:
    slip = specimen.elastic.change_per_mu("platen_slip", mixture, travel)
    return values["share"] * slip + _loop(specimen, mixture, travel, values["share"])


def _loop(specimen: Specimen, mixture: float, travel: Array, share: float) -> Array:
    """Change (n,) [m2] from loading to the way back.

    Between the three runs, sticking, with friction, and without, it is linear in the share of the
    slip: a sample that sticks does not rub, and sliding without friction costs nothing. The run
    turns where the family ends; elsewhere the loop is the same part of the force at the turn, at
    the same part of the way.
    """
    elastic = specimen.elastic
    if "platen_friction_loop" not in elastic.variants:
        return np.zeros_like(travel)
    change, end = partial(elastic.change_per_mu, mixture=mixture), elastic.family.displacement[-1:]
    rubbing = change("platen_friction", travel=end) / change("platen_slip", travel=end)
    share_of_run = np.clip(rubbing.item(), 0.01, 0.99)
    size = np.interp(share, [0.0, share_of_run, 1.0], [0.0, 1.0, 0.0])
    turn = np.maximum.accumulate(np.maximum(travel, 1e-3 * end))
    way = travel / turn
    loop = change("platen_friction_loop", travel=end * way)
    loop -= way * change("platen_friction_loop", travel=end)  # smoothing leaves some at the turn
    at_turn, at_end = (elastic.force_per_mu(mixture, where) for where in (turn, end))
    return np.where(specimen.phase == "ramp", 0.0, size * loop * at_turn / at_end)


EFFECT = Effect(
    name="platen_slip",
    title="Slip on the platen",
    parameters=(Parameter("share", "1", 0.0, 1.0, 0.3),),
    tier="M",
    source="Rashid, Destrade, Gilchrist, J. Mech. Behav. Biomed. Mater. 12 (2012); own runs "
    "without friction, and there and back with a coefficient of 0.1",
    signature="compression softer, more so with the stroke; on the way back below the loading",
    confused_with=("tension_compression_asymmetry", "poisson_ratio", "partial_bond"),
    experiment="marks on the edge of the top; glue the compression sample",
    modes=("compression",),
    elastic=_elastic,
)
