"""What an elastic law is: its parameters, and one text of its energy and its derivatives.

All laws are per modulus. The text of a law is plain arithmetic and what
`softsample.constitutive.functions` has; `softsample.constitutive.material` runs it on NumPy
arrays, real or complex, and the solver's kernel compiles it. So a text has no powers with `**`,
no comparison of strains and no NumPy; numbers of `shape` may be compared.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np


@dataclass(frozen=True)
class Parameter:
    """A number that gives a law its shape, besides the modulus.

    Parameters
    ----------
    name, unit, title : str
        Name in tables and files, unit (`1` for none), words for a page.
    low, high, default : float
        Range that a fit searches, and a value to start from.
    least, most : float
        Limits beyond which the law does not exist.
    """

    name: str
    unit: str
    low: float
    high: float
    default: float
    title: str
    least: float = -np.inf
    most: float = np.inf


class Law(ABC):
    """An elastic law per modulus; one subclass per file of `softsample.constitutive.laws`.

    The modulus is the initial shear modulus, but for fibres (`FibreLaw`), which have no part in
    that of small strain without direction.
    """

    name: ClassVar[str]
    """Name in terms, tables and files."""
    title: ClassVar[str]
    """Words for a page."""
    energy: ClassVar[str]
    """Strain energy per modulus, as a formula of plain text."""
    source: ClassVar[str]
    """Where the law is from, with its DOI."""
    shape: ClassVar[tuple[Parameter, ...]] = ()
    """Shape parameters in the order of a term's numbers."""

    def check(self, shape: Sequence[float]) -> None:
        """Refuse shape parameters that the law does not have.

        Raises
        ------
        ValueError
            With the parameter, its value and its limits.
        """
        if len(shape) != len(self.shape):
            names = ", ".join(p.name for p in self.shape) or "no shape parameter"
            raise ValueError(f"{self.name} has {names}; got {tuple(shape)}")
        for parameter, value in zip(self.shape, shape, strict=True):
            if not (np.isfinite(value) and parameter.least <= value <= parameter.most):
                raise ValueError(
                    f"{self.name}: {parameter.name} must be finite, from {parameter.least:g} to "
                    f"{parameter.most:g}, got {value}"
                )

    def even_power(self, shape: Sequence[float]) -> bool:
        """Whether the law is a trace of a whole power of Cbar, so that products of it do."""
        return False

    def poisson_ratio(self, shape: Sequence[float]) -> float | None:
        """Poisson's ratio of a law that is of the volume as well, None if it is not."""
        return None


class InvariantLaw(Law):
    """An isotropic law in the first two invariants of the isochoric Cbar = J^(-2/3) C."""

    @staticmethod
    @abstractmethod
    def slopes(x: Any, y: Any, shape: Any) -> tuple[Any, Any, Any]:
        """Energy W and its derivatives by I1 and I2, at x = I1 - 3 and y = I2 - 3."""


class SpectralLaw(Law):
    """An isotropic law in the principal stretches."""

    @staticmethod
    @abstractmethod
    def principal(x: Any, y: Any, z: Any, jacobian: Any, shape: Any) -> tuple[Any, Any, Any, Any]:
        """Energy and the three principal Kirchhoff stresses.

        `x`, `y`, `z` are logarithms of the isochoric principal stretches, sum zero. The stresses
        have no mean, unless the law is of the volume as well.
        """


class FibreLaw(Law):
    """A law of the first invariant and of the stretch along a direction a, of isochoric Cbar."""

    @staticmethod
    @abstractmethod
    def slopes(x: Any, e: Any, shape: Any) -> tuple[Any, Any, Any]:
        """Energy W and its derivatives by I1 and I4, at x = I1 - 3 and e = I4 - 1."""
