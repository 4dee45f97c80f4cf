"""Numbers and names of loadings as people read them."""

from collections.abc import Mapping

DIGITS = 3
"""Significant digits of a result."""


def significant(value: float, digits: int = DIGITS) -> str:
    """A number rounded to significant digits, without an exponent unless it is tiny."""
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:.0f}" if abs(rounded) >= 10.0**digits else f"{rounded:.{digits}g}"


NEGLIGIBLE = 1e-5
"""Magnitude [mm, mN, s, degrees, parts, percent] below which a fitted value is zero to a reader."""

NO_ERROR = 1e-3
"""Error [% of peak] below which, the noise taken out, nothing is left of it."""

VERDICTS = {"none": "none (no missing effect detected)"}
"""Verdicts that a reader could misunderstand, with what they mean."""


def fitted(value: float) -> str:
    """A fitted value; one that ended at a bound of zero, or below any rounding, is 0."""
    return "0" if abs(value) < NEGLIGIBLE else significant(value)


def structured(percent: float, digits: int = DIGITS) -> str:
    """An error without noise [%]; one that the noise explains is not zero but below that."""
    return "< noise" if percent < NO_ERROR else significant(percent, digits)


def verdict_words(verdict: str) -> str:
    """A verdict, with its meaning where the word alone could be misunderstood."""
    return VERDICTS.get(verdict, verdict)


OVERLOADED = "Load cell overloaded"
"""What a record says that stays at its largest force."""


def at_its_limit(forces: Mapping[str, float]) -> str:
    """Samples with the force [N] at which the load cell stayed."""
    return ", ".join(f"{name} stays at {significant(force)} N" for name, force in forces.items())


def overload_told(forces: Mapping[str, float]) -> str:
    """What to say of records that stay at their largest force, after `OVERLOADED`."""
    return (
        f"{at_its_limit(forces)}. What lies beyond was not measured: trust neither modulus nor "
        "effects. Test within the range of the cell, or hold out what it cut off."
    )


def true_minus(text: str) -> str:
    """A number with a minus sign in place of the hyphen."""
    return text.replace("-", "−")


def spoken(loading: str) -> str:
    """Loading mode, or several joined by `+`, in words."""
    return loading.replace("_", " ").replace("+", " and ")
