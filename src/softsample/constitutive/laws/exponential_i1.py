"""Exponential solid in the first invariant."""

from typing import Any

from softsample.constitutive.functions import exp, growth
from softsample.constitutive.law import InvariantLaw, Parameter


class ExponentialI1(InvariantLaw):
    """W = (exp(b (I1 - 3)) - 1) / (2 b), of Demiray and Fung."""

    name = "exponential_i1"
    title = "Exponential in I1 (Demiray, Fung)"
    energy = "(exp(b (I1 - 3)) - 1) / (2 b)"
    source = "H. Demiray, J. Biomech. 5 (1972) 309, doi:10.1016/0021-9290(72)90047-4"
    shape = (Parameter("b", "1", 0.0, 100.0, 5.0, "exponent of I1 - 3"),)

    @staticmethod
    def slopes(x: Any, y: Any, shape: Any) -> tuple[Any, Any, Any]:
        """See `InvariantLaw.slopes`."""
        share = shape[0] * x
        return 0.5 * x * growth(share), 0.5 * exp(share), 0.0


LAW = ExponentialI1()
