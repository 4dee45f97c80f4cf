"""What of a set is calibrated on and what is held out: rules that know nothing of the forces."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from softsample.measured.measurement import Measurement
from softsample.protocol import travel_sign


@dataclass(frozen=True)
class Part:
    """Part of a record.

    Parameters
    ----------
    test : Measurement
        The record.
    low, high : float
        Nominal strains along the loading between which samples count.
    way_back : bool
        Whether all of the way back up to `high` counts as well.
    channel : str
        `force` or `force_normal`.
    """

    test: Measurement
    low: float
    high: float
    way_back: bool = False
    channel: str = "force"

    @property
    def until(self) -> int:
        """Samples up to where the strain first passes `high`, or all with the way back."""
        strain = travel_sign(self.test.mode) * self.test.strain
        beyond = np.flatnonzero(strain > self.high)
        return len(strain) if self.way_back or len(beyond) == 0 else int(beyond[0])

    def counts(self, strain: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which samples count (n,), of strains along the loading in the order of the record."""
        back = np.arange(len(strain)) > int(strain.argmax())
        inside = (strain > self.low) & (strain <= self.high) & ~back
        return inside | (back & (strain <= self.high) & self.way_back)


@dataclass(frozen=True)
class Case:
    """A group of records: what is fitted, and what the fit is judged on."""

    name: str
    fitted: list[Part]
    held_out: list[Part]


@dataclass(frozen=True)
class SplitSettings:
    """Mirrors a set's keys in config `measured:`.

    Parameters
    ----------
    held_out : str
        Name of the rule, a key of `RULES`.
    reach : float
        Largest nominal strain that is used.
    fitted_reach : float
        Largest one that is fitted, for the rules that hold out larger strains.
    """

    held_out: str
    reach: float
    fitted_reach: float = 0.0


def split(tests: Sequence[Measurement], settings: SplitSettings) -> list[Case]:
    """Cases of a set, in the order of its groups."""
    rule = RULES[settings.held_out]
    groups = groupby(sorted(tests, key=lambda test: test.group), key=lambda test: test.group)
    return [case for name, group in groups for case in rule(name, list(group), settings)]


def _other_specimen(name: str, tests: list[Measurement], settings: SplitSettings) -> list[Case]:
    """The first specimen is fitted, the others are held out."""
    first = min(test.specimen for test in tests)
    parts = [Part(test, -np.inf, settings.reach) for test in tests]
    return [
        Case(
            name,
            [part for part in parts if part.test.specimen == first],
            [part for part in parts if part.test.specimen != first],
        )
    ]


def _larger_strain(name: str, tests: list[Measurement], settings: SplitSettings) -> list[Case]:
    """What follows a strain is held out."""
    low, high = settings.fitted_reach, settings.reach
    return [Case(name, [Part(t, -np.inf, low) for t in tests], [Part(t, low, high) for t in tests])]


def _larger_strain_and_way_back(
    name: str, tests: list[Measurement], settings: SplitSettings
) -> list[Case]:
    """What follows a strain is held out, and all of the way back."""
    low, high = settings.fitted_reach, settings.reach
    held_out = [Part(t, low, high, way_back=True) for t in tests]
    return [Case(name, [Part(t, -np.inf, low) for t in tests], held_out)]


def _normal_force(name: str, tests: list[Measurement], settings: SplitSettings) -> list[Case]:
    """The shear force is fitted, the normal force is held out."""
    fitted = [Part(test, -np.inf, settings.reach) for test in tests]
    held_out = [Part(test, 0.0, settings.reach, channel="force_normal") for test in tests]
    return [Case(name, fitted, held_out)]


def _other_modes(name: str, tests: list[Measurement], settings: SplitSettings) -> list[Case]:
    """One mode after the other is fitted, the others are held out."""
    parts = [Part(test, -np.inf, settings.reach) for test in tests]
    return [
        Case(
            f"{name}_{mode}",
            [part for part in parts if part.test.mode == mode],
            [part for part in parts if part.test.mode != mode],
        )
        for mode in dict.fromkeys(test.mode for test in tests)
    ]


RULES: Mapping[str, Callable[[str, list[Measurement], SplitSettings], list[Case]]] = {
    "other_specimen": _other_specimen,
    "larger_strain": _larger_strain,
    "larger_strain_and_way_back": _larger_strain_and_way_back,
    "normal_force": _normal_force,
    "other_modes": _other_modes,
}
