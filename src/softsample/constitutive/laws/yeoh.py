"""Yeoh's solid of three terms."""

from typing import Any

from softsample.constitutive.law import InvariantLaw, Parameter


class Yeoh(InvariantLaw):
    """W = 1/2 (x + c2 x^2 + c3 x^3) with x = I1 - 3, so that c2 = C20/C10 and c3 = C30/C10."""

    name = "yeoh"
    title = "Yeoh"
    energy = "1/2 ((I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3)"
    source = "O. H. Yeoh, Rubber Chem. Technol. 66 (1993) 754, doi:10.5254/1.3538343"
    shape = (
        Parameter("c2", "1", 0.0, 50.0, 1.0, "quadratic over linear coefficient"),
        Parameter("c3", "1", 0.0, 1000.0, 1.0, "cubic over linear coefficient"),
    )

    @staticmethod
    def slopes(x: Any, y: Any, shape: Any) -> tuple[Any, Any, Any]:
        """See `InvariantLaw.slopes`."""
        quadratic, cubic = shape[0], shape[1]
        energy = 0.5 * x * (1.0 + x * (quadratic + cubic * x))
        return energy, 0.5 + x * (quadratic + 1.5 * cubic * x), 0.0


LAW = Yeoh()
