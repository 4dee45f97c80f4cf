"""The library of effects fitted to others' samples: their size, force, exponents and clock."""

from dataclasses import replace

from softsample.loop.effects import library
from softsample.loop.effects.base import SOLID, Effect, Parameter

OF_TIME = (
    "channel_lag", "dehydration", "force_drift", "poroelastic_drainage", "rate_stiffening",
    "viscoelastic_relaxation",
)  # fmt: skip
"""Effects that a record without time cannot show."""

HEIGHT = 13e-3
"""Height [m] of the samples that ranges of lengths in the library are made for."""

PEAK = 1.0
"""Typical peak force [N] of their tests."""


def fitted_library(
    alpha: tuple[float, float], height: float, peak: float, timed: bool, sticks: bool = True
) -> list[Effect]:
    """Effects with ranges in proportion to a sample's height [m] and peak force [N].

    Mains pickup is left out: its many periods are those of a cell that is read at 100 Hz. Where
    the model does not stick to the platens, the share of slip runs from none (0) to sticking (-1).
    """
    scales = {
        "mm": height / HEIGHT,
        "mN": peak / PEAK,
        "mN/s": peak / PEAK,
        "mm/N": (height / HEIGHT) / (peak / PEAK),
    }
    left_out = {"mains_pickup", *(() if timed else OF_TIME)}
    solid = replace(SOLID, alpha=alpha)
    known = {name: e for name, e in library(solid).items() if name not in left_out}
    if not sticks:
        stick = Parameter("share", "1", -1.0, 0.0, -0.3)
        known["platen_slip"] = replace(known["platen_slip"], parameters=(stick,))
    return [_scaled(effect, scales) for effect in known.values()]


def _scaled(effect: Effect, scales: dict[str, float]) -> Effect:
    return replace(
        effect,
        parameters=tuple(
            _stretched(p, scales[p.unit]) if p.unit in scales else p for p in effect.parameters
        ),
    )


def _stretched(parameter: Parameter, by: float) -> Parameter:
    return replace(
        parameter,
        low=by * parameter.low,
        high=by * parameter.high,
        nominal=by * parameter.nominal,
        neutral=by * parameter.neutral,
        grid=tuple(by * value for value in parameter.grid),
    )
