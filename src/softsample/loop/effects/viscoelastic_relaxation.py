"""The tissue relaxes: quasi-linear viscoelasticity with three times that suit the records."""

import math
from collections.abc import Sequence

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values
from softsample.loop.history import relaxed

LEAST_FORCE = 0.02
"""Part of the largest force below which the part that is left of it says nothing."""

LEAST_LOST = 1e-6
"""Part of the modulus that is taken for lost at least: a slope is wanted where none is."""

SIZES = ("g1", "g2", "g3")
"""Parts of the force that are lost in the end, at times of equal ratio from the first to the last.

Three terms follow stretched exponentials and power laws to 1 % of the lost force over a ramp, a
hold of up to a hundred times its duration and the unloading.
"""

BRIEFEST = 0.05
"""Part of the loading time: what relaxes faster is a scale."""

LONGEST = 3.0
"""Multiple of the duration: what relaxes slower is a line."""

LEAST_SPAN = 16.0
"""Duration over the briefest time, at least."""


def _tissue(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    found = force
    for size, tau in zip(SIZES, _times(values), strict=True):
        if values[size]:
            found = found + relaxed(specimen.time, force, values[size], tau) - force
    return found


def _lost(values: Values, duration: float) -> float:
    """Part of a step's force that is lost within a duration [s]."""
    return sum(
        values[size] * -math.expm1(-duration / tau)
        for size, tau in zip(SIZES, _times(values), strict=True)
    )


def _times(values: Values) -> tuple[float, float, float]:
    """Relaxation times [s]."""
    first, last = values["tau1_s"], values["tau3_s"]
    return first, math.sqrt(first * last), last


def _elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    """What a bulk modulus that stays adds, by the correspondence of elastic and relaxed.

    With less of its shear modulus the tissue is less compressible: its Poisson's ratio rises. The
    change is proportional to what has relaxed, on unloading too, where that is more than is
    left of the elastic force; how much it is goes by the part of the modulus that is left.
    """
    if not values["bulk"]:
        return np.zeros_like(travel)
    force = specimen.elastic.force_per_mu(fraction, travel)
    lost = force - _tissue(specimen, force, travel, values)
    felt = np.maximum(np.abs(force), LEAST_FORCE * np.abs(force).max())
    most = min(sum(values[size] for size in SIZES), 1.0)
    part = np.clip(lost * np.sign(force) / felt, LEAST_LOST, max(most, LEAST_LOST))
    softer = specimen.elastic.softer_change_per_mu(fraction, travel, 1.0 - part)
    leaves = specimen.elastic.contact and specimen.elastic.release
    over = felt if leaves else np.abs(force)  # a platen that leaves ends it
    ratio = np.sign(force) * np.divide(softer, over, out=np.zeros_like(force), where=over > 0.0)
    return values["bulk"] * ratio * lost / part


def within(briefest: float, duration: float) -> Effect:
    """The effect with times [s] between the briefest and the duration that records can show."""
    middle = float(np.sqrt(briefest * duration))
    last = LONGEST * duration
    return Effect(
        name="viscoelastic_relaxation",
        title="Viscoelastic relaxation",
        parameters=(
            *(Parameter(size, "1", 0.0, 0.9, 0.1) for size in SIZES),
            Parameter("tau1_s", "s", briefest, middle, 2.0 * briefest, grid=(2.0 * briefest,)),
            Parameter(
                "tau3_s", "s", middle, last, 2.0 * middle, grid=(2.0 * middle, 0.5 * duration)
            ),
            Parameter("bulk", "1", 0.0, 1.0, 1.0, grid=(1.0,)),
        ),
        starts=tuple(
            {**dict.fromkeys(SIZES, 0.1), "tau1_s": first, "tau3_s": third, "bulk": 0.0}
            for first, third in (
                (2.0 * briefest, 2.0 * middle),
                (math.sqrt(briefest * middle), 0.25 * duration),
            )
        ),
        whole=lambda values: _lost(values, duration),
        of_time=True,
        source="Budday et al., Acta Biomater. 48 (2017) 319, doi:10.1016/j.actbio.2016.10.036; "
        "bulk modulus: Tschoegl et al., Mech. Time-Depend. Mater. 6 (2002) 3, "
        "doi:10.1023/A:1014411503170",
        signature="concave ramp, decay in the hold of every mode, most in shear; loop on unloading",
        confused_with=("poroelastic_drainage", "force_drift", "mullins_softening"),
        experiment="a hold ten times as long, in shear as well as in compression",
        elastic=_elastic,
        tissue=_tissue,
    )


def of_tests(tests: Sequence[Specimen]) -> Effect:
    """The effect with times that suit the fastest loading and the longest record of a group."""
    brief = max(
        BRIEFEST * min(specimen.loading_time for specimen in tests),
        min(float(np.median(np.diff(specimen.time))) for specimen in tests),
    )
    duration = max(float(specimen.clock[-1]) for specimen in tests)
    return within(brief, max(duration, LEAST_SPAN * brief))


EFFECT = within(0.5, 100.0)
