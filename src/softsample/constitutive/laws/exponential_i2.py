"""Exponential solid in the second invariant."""

from typing import Any

from softsample.constitutive.functions import exp, growth
from softsample.constitutive.law import InvariantLaw, Parameter


class ExponentialI2(InvariantLaw):
    """W = (exp(b (I2 - 3)) - 1) / (2 b)."""

    name = "exponential_i2"
    title = "Exponential in I2"
    energy = "(exp(b (I2 - 3)) - 1) / (2 b)"
    source = (
        "C. O. Horgan, M. G. Smayda, Mech. Mater. 51 (2012) 43, doi:10.1016/j.mechmat.2012.03.007"
    )
    shape = (Parameter("b", "1", 0.0, 100.0, 5.0, "exponent of I2 - 3"),)

    @staticmethod
    def slopes(x: Any, y: Any, shape: Any) -> tuple[Any, Any, Any]:
        """See `InvariantLaw.slopes`."""
        share = shape[0] * y
        return 0.5 * y * growth(share), 0.0, 0.5 * exp(share)


LAW = ExponentialI2()
