"""Numbers and names of loadings as people read them."""

from collections.abc import Mapping
from typing import Any

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


def distrusted(verdict: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Why neither modulus nor effects are to be trusted: by title, which samples, and the cure."""
    found = {
        "Load cell overloaded": (
            [
                f"{name} stays at {significant(at)} N"
                for name, at in verdict["overloaded_N"].items()
            ],
            "What lies beyond was not measured: trust neither modulus nor effects. Test within the "
            "range of the cell, or hold out what it cut off. If the force was given (creep), that "
            "is no test of this model.",
        ),
        "Not simulated to the end": (
            [
                f"{name} to {significant(ends['simulated'])} of {significant(ends['fitted'])} mm"
                for name, ends in verdict["extrapolated_mm"].items()
            ],
            "Beyond, elements give way and the force is extrapolated: trust neither modulus nor "
            "effects. Hold out what lies beyond (`strain_above`), or state sliding ends if they "
            "slide.",
        ),
    }
    return {title: (", ".join(of), cure) for title, (of, cure) in found.items() if of}


def true_minus(text: str) -> str:
    """A number with a minus sign in place of the hyphen."""
    return text.replace("-", "−")


def spoken(loading: str) -> str:
    """Loading mode, or several joined by `+`, in words."""
    return loading.replace("_", " ").replace("+", " and ")
