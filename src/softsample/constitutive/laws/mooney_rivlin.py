"""Mooney-Rivlin solid."""

from typing import Any

from softsample.constitutive.law import InvariantLaw, Parameter


class MooneyRivlin(InvariantLaw):
    """W = 1/2 ((1 - s)(I1 - 3) + s (I2 - 3)), so that C10 = (1 - s) mu/2 and C01 = s mu/2."""

    name = "mooney_rivlin"
    title = "Mooney-Rivlin"
    energy = "1/2 ((1 - s) (I1 - 3) + s (I2 - 3))"
    source = "M. Mooney, J. Appl. Phys. 11 (1940) 582, doi:10.1063/1.1712836"
    shape = (Parameter("s", "1", 0.0, 1.0, 0.5, "share of the second invariant"),)

    @staticmethod
    def slopes(x: Any, y: Any, shape: Any) -> tuple[Any, Any, Any]:
        """See `InvariantLaw.slopes`."""
        second = 0.5 * shape[0]
        first = 0.5 - second
        return first * x + second * y, first, second


LAW = MooneyRivlin()
