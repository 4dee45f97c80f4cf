"""Neo-Hookean solid."""

from typing import Any

from softsample.constitutive.law import InvariantLaw


class NeoHooke(InvariantLaw):
    """W = 1/2 (I1 - 3)."""

    name = "neo_hooke"
    title = "Neo-Hooke"
    energy = "1/2 (I1 - 3)"
    source = "R. S. Rivlin, Phil. Trans. R. Soc. Lond. A 240 (1948) 459, doi:10.1098/rsta.1948.0002"

    @staticmethod
    def slopes(x: Any, y: Any, shape: Any) -> tuple[Any, Any, Any]:
        """See `InvariantLaw.slopes`."""
        return 0.5 * x, 0.5, 0.0


LAW = NeoHooke()
