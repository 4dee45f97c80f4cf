"""Foam of Ogden and Storakers."""

from collections.abc import Sequence
from typing import Any

from softsample.constitutive.functions import expm1, growth, log
from softsample.constitutive.law import Parameter, SpectralLaw


class Foam(SpectralLaw):
    """W = 2/alpha^2 (sum l^alpha - 3 + (J^(-alpha beta) - 1)/beta), beta = nu/(1 - 2 nu).

    The stretches l are whole ones, not isochoric: free sides contract as l^(-nu) at any strain.
    At nu = 0 the last term is -alpha ln J, at alpha = 0 the law is that of Hencky.
    """

    name = "foam"
    title = "Foam (Ogden, Storakers)"
    energy = "2/alpha^2 (l1^alpha + l2^alpha + l3^alpha - 3 + (J^(-alpha beta) - 1)/beta)"
    source = "B. Storakers, J. Mech. Phys. Solids 34 (1986) 125, doi:10.1016/0022-5096(86)90033-5"
    shape = (
        Parameter("alpha", "1", -45.0, 40.0, 8.0, "exponent"),
        Parameter("nu", "1", 0.0, 0.49, 0.3, "Poisson's ratio", least=0.0, most=0.4995),
    )

    @staticmethod
    def principal(x: Any, y: Any, z: Any, jacobian: Any, shape: Any) -> tuple[Any, Any, Any, Any]:
        """See `SpectralLaw.principal`."""
        exponent, coupling = shape[0], shape[1] / (1.0 - 2.0 * shape[1])
        volume = log(jacobian)
        share = (1.0 / 3.0) * volume
        x, y, z = x + share, y + share, z + share
        if exponent == 0.0:
            mean = coupling * volume
            energy = x * x + y * y + z * z + mean * volume
            return energy, 2.0 * (x + mean), 2.0 * (y + mean), 2.0 * (z + mean)
        p, q, r = expm1(exponent * x), expm1(exponent * y), expm1(exponent * z)
        factor, push = 2.0 / exponent, -exponent * coupling * volume
        whole = expm1(push)
        energy = (factor / exponent) * (p + q + r) - factor * volume * growth(push)
        return energy, factor * (p - whole), factor * (q - whole), factor * (r - whole)

    def poisson_ratio(self, shape: Sequence[float]) -> float:
        """See `Law.poisson_ratio`."""
        return float(shape[1])


LAW = Foam()
