"""Ogden's solid of one term; several terms are a sum."""

from collections.abc import Sequence
from typing import Any

from softsample.constitutive.functions import expm1
from softsample.constitutive.law import Parameter, SpectralLaw


class Ogden(SpectralLaw):
    """W = 2/alpha^2 (sum lbar^alpha - 3), in the limit alpha = 0 the sum of (ln lbar)^2."""

    name = "ogden"
    title = "Ogden"
    energy = "2/alpha^2 (l1^alpha + l2^alpha + l3^alpha - 3)"
    source = "R. W. Ogden, Proc. R. Soc. Lond. A 326 (1972) 565, doi:10.1098/rspa.1972.0026"
    shape = (Parameter("alpha", "1", -45.0, 40.0, 2.0, "exponent"),)

    @staticmethod
    def principal(x: Any, y: Any, z: Any, jacobian: Any, shape: Any) -> tuple[Any, Any, Any, Any]:
        """See `SpectralLaw.principal`."""
        exponent = shape[0]
        if exponent == 0.0:
            return x * x + y * y + z * z, 2.0 * x, 2.0 * y, 2.0 * z
        p, q, r = expm1(exponent * x), expm1(exponent * y), expm1(exponent * z)
        factor, total = 2.0 / exponent, p + q + r
        mean = (1.0 / 3.0) * total
        return (
            (factor / exponent) * total,
            factor * (p - mean),
            factor * (q - mean),
            factor * (r - mean),
        )

    def even_power(self, shape: Sequence[float]) -> bool:
        """See `Law.even_power`."""
        return shape[0] != 0.0 and float(shape[0]) % 2.0 == 0.0


LAW = Ogden()
