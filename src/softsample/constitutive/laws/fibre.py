"""One family of dispersed fibres."""

from typing import Any

from softsample.constitutive.functions import exp, growth, positive
from softsample.constitutive.law import FibreLaw, Parameter


class Fibre(FibreLaw):
    """W = (exp(k2 E^2) - 1) / (2 k2) with E = kappa (I1 - 3) + (1 - 3 kappa)(I4 - 1).

    The modulus is k1. Where E is negative the fibres are shortened, and keep a part `pushed` of
    this energy: none in the law of Holzapfel and others, all of it in fibres that do not buckle.
    At k2 = 0 the energy is E^2/2.
    """

    name = "fibre"
    title = "Fibres (Holzapfel, Gasser, Ogden)"
    energy = "(exp(k2 E^2) - 1) / (2 k2), E = kappa (I1 - 3) + (1 - 3 kappa) (I4 - 1)"
    source = (
        "T. C. Gasser, R. W. Ogden, G. A. Holzapfel, J. R. Soc. Interface 3 (2006) 15, "
        "doi:10.1098/rsif.2005.0073"
    )
    shape = (
        Parameter("k2", "1", 0.0, 100.0, 1.0, "exponent", least=0.0),
        Parameter("kappa", "1", 0.0, 1.0 / 3.0, 0.0, "dispersion", least=0.0, most=1.0 / 3.0),
        Parameter("pushed", "1", 0.0, 1.0, 0.0, "part kept in compression", 0.0, 1.0),
    )

    @staticmethod
    def slopes(x: Any, e: Any, shape: Any) -> tuple[Any, Any, Any]:
        """See `FibreLaw.slopes`."""
        dispersion, kept = shape[1], shape[2]
        aligned = 1.0 - 3.0 * dispersion
        strain = dispersion * x + aligned * e
        part = kept + (1.0 - kept) * positive(strain)
        square = strain * strain
        slope = part * strain * exp(shape[0] * square)
        return 0.5 * part * square * growth(shape[0] * square), dispersion * slope, aligned * slope


LAW = Fibre()
