"""Each sample of a group has a modulus of its own."""

from collections.abc import Sequence

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _tissue(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    return force * values.get(specimen.name, 1.0)


def of_names(names: Sequence[str]) -> Effect:
    """The effect for samples by their names."""
    return Effect(
        name="specimen_stiffness",
        title="Stiffness of single samples",
        parameters=tuple(Parameter(name, "1", 0.5, 2.0, 1.1, neutral=1.0) for name in names),
        tier="P",
        like_floor=True,
        source="scatter of repeats; each size is the modulus of a sample over that of the group's "
        "first of the same mode",
        signature="all forces of a sample scaled against those of another one in the same test",
        confused_with=("gain", "rate_stiffening", "dehydration"),
        experiment="test one sample twice, and two samples alike",
        tissue=_tissue,
    )


def of_tests(tests: Sequence[Specimen]) -> Effect | None:
    """The effect, with a size for each sample of which another one came before in the same mode."""
    first = {specimen.mode: specimen.name for specimen in reversed(tests)}
    later = dict.fromkeys(s.name for s in tests if s.name != first[s.mode])
    return of_names(list(later)) if later else None


EFFECT = of_names(["sample"])
