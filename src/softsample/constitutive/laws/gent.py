"""Gent's solid of limited extensibility."""

from typing import Any

from softsample.constitutive.functions import lesser, log
from softsample.constitutive.law import InvariantLaw, Parameter

REACH = 0.999
"""Part of the limit up to which the law holds; beyond, its slope stays, so that closed forms have
an answer at every strain that a fit passes through. The solver refuses strains near the limit."""


class Gent(InvariantLaw):
    """W = -Jm/2 ln(1 - (I1 - 3)/Jm), up to I1 - 3 = 0.999 Jm."""

    name = "gent"
    title = "Gent"
    energy = "-Jm/2 ln(1 - (I1 - 3)/Jm)"
    source = "A. N. Gent, Rubber Chem. Technol. 69 (1996) 59, doi:10.5254/1.3538357"
    shape = (Parameter("Jm", "1", 0.02, 100.0, 1.0, "limit of I1 - 3", least=1e-6),)

    @staticmethod
    def slopes(x: Any, y: Any, shape: Any) -> tuple[Any, Any, Any]:
        """See `InvariantLaw.slopes`."""
        limit = shape[0]
        inside = lesser(x, REACH * limit)
        left = 1.0 - inside * (1.0 / limit)
        slope = 0.5 / left
        return slope * (x - inside) - 0.5 * limit * log(left), slope, 0.0


LAW = Gent()
