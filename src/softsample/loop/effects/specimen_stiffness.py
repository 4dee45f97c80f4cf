"""Each specimen of a group has a modulus of its own."""

from collections.abc import Sequence

from softsample.loop.effects.base import Effect, Parameter, Specimen


def of_names(names: Sequence[str]) -> Effect:
    """The effect for specimens by their names."""
    return Effect(
        name="specimen_stiffness",
        title="Stiffness of single specimens",
        parameters=tuple(Parameter(name, "1", 0.5, 2.0, 1.1, neutral=1.0) for name in names),
        like_geometry=True,
        source="scatter of repeats; each size is the modulus of a specimen over that of the "
        "group's first of the same mode, or over the geometric mean where they scatter",
        signature="all forces of a specimen scaled relative to those of another in the same test",
        confused_with=("gain", "rate_stiffening", "dehydration"),
        experiment="test one specimen twice, and two specimens alike",
        tissue=lambda specimen, force, travel, values: force * values.get(specimen.piece, 1.0),
    )


def of_tests(tests: Sequence[Specimen]) -> Effect | None:
    """The effect, with a size for each specimen before which another one had its test.

    That is one of its mode and directions. Of what is held out of every test, nothing would be
    learned.
    """
    fitted = [test for test in tests if not test.held_out.all()]
    first = {test.way: test.piece for test in reversed(fitted)}
    later = dict.fromkeys(test.piece for test in fitted if test.piece != first[test.way])
    return of_names(list(later)) if later else None


EFFECT = of_names(["specimen"])
