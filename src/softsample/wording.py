"""Numbers and names of loadings as people read them."""

DIGITS = 3
"""Significant digits of a result."""


def significant(value: float, digits: int = DIGITS) -> str:
    """A number rounded to significant digits, without an exponent unless it is tiny."""
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:.0f}" if abs(rounded) >= 10.0**digits else f"{rounded:.{digits}g}"


def true_minus(text: str) -> str:
    """A number with a minus sign in place of the hyphen."""
    return text.replace("-", "−")


def spoken(loading: str) -> str:
    """Loading mode, or several joined by `+`, in words."""
    return loading.replace("_", " ").replace("+", " and ")
