"""Effects that a group's records may show, with ranges that suit their size, force and clock."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from softsample.constitutive.material import Material
from softsample.loop.effects import library, self_weight
from softsample.loop.effects.base import Effect, Parameter
from softsample.loop.specimen import Specimen

HEIGHTS = (6.5e-3, 26e-3)
"""Heights [m] of samples whose ranges of lengths hold as they are: 13 mm by a factor of two."""

PEAKS = (0.2, 5.0)
"""Peak forces [N] of tests whose ranges of forces hold as they are: 1 N by a factor of five."""

RIPPLE_HZ = (95.0, 105.0)
"""Sampling rates [Hz] that fold the ripple of the mains, of 100 Hz, to that effect's periods."""


def candidates(specimens: Sequence[Specimen], height: float, solid: Material) -> list[Effect]:
    """The library for the records of a group.

    Effects of time are no candidates without recorded time, and none that goes by where the platen
    has been if a record without time sweeps to both sides. A law has the exponents whose response
    is known (`softsample.response.law_response`). Ranges go with the size of the sample and the
    peak force where these are far from the study's; no known shape pulls by more than it weighs.

    Parameters
    ----------
    height : float
        Of the samples [m].
    solid : Material
        What the model is made of.
    """
    timed = all(s.timed for s in specimens)
    followed = not any(s.is_sweep for s in specimens)
    rippled = timed and all(RIPPLE_HZ[0] < _rate(s) < RIPPLE_HZ[1] for s in specimens)
    length = _beyond(height, HEIGHTS)
    peaks = [s.peak for s in specimens if not s.held_out.all()]
    force = _beyond(float(np.median(peaks)), PEAKS)
    scales = {"mm": length, "mN": force, "mN/s": force, "mm/N": length / force}
    weights = [s.elastic.weight for s in specimens if s.elastic.weight is not None]
    weight = 1e3 * max(weights) / self_weight.MOST_MN if weights else force
    laws = [s.elastic.laws.exponents for s in specimens if s.elastic.laws is not None]
    there = {
        "mains_pickup": rippled,
        "elastic_law": len(laws) == len(specimens),
        "ogden_exponents": len(laws) == len(specimens),
        "compressible_foam": all(s.elastic.knows_foams for s in specimens),
    }
    known = max((low for low, _ in laws), default=0.0), min((high for _, high in laws), default=0.0)
    return [
        _suited(effect, scales | ({"mN": weight} if effect.name == "self_weight" else {}), known)
        for effect in library(solid, specimens).values()
        if (timed or not effect.of_time)
        and (followed or not effect.of_past)
        and there.get(effect.name, True)
    ]


def _rate(specimen: Specimen) -> float:
    """Sampling rate [Hz]."""
    return float(1.0 / np.median(np.diff(specimen.time)))


def _beyond(value: float, ends: tuple[float, float]) -> float:
    """Ratio of a value to the nearer end of a range; 1 within it."""
    return float(value / np.clip(value, *ends))


def _suited(effect: Effect, scales: Mapping[str, float], exponents: tuple[float, float]) -> Effect:
    """An effect with ranges that are scaled by their unit.

    Exponents of a law lie between those whose response was simulated.
    """
    least, most = exponents

    def suited(p: Parameter) -> Parameter:
        if effect.is_law and p.name.startswith("alpha"):
            grid = tuple(value for value in p.grid if least <= value <= most)
            return replace(p, low=max(p.low, least), high=min(p.high, most), grid=grid)
        by, names = scales.get(p.unit, 1.0), ("low", "high", "nominal", "neutral")
        scaled: dict[str, Any] = {name: by * getattr(p, name) for name in names}
        scaled |= {m: tuple(by * x for x in getattr(p, m)) for m in ("grid", "limits")}
        return replace(p, **scaled)

    return replace(effect, parameters=tuple(map(suited, effect.parameters)))
