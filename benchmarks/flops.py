"""Floating-point operations of one element, counted by running the kernel's source.

With Numba switched off the kernel is plain Python; here it runs on one element whose numbers
count. Different additions, multiplications and divisions count one each. What the compiler saves
is not counted: an operation done before with the same numbers, sums with zero, products with one
(the signs of the hourglass patterns). Functions count what their vector code in
`softsample.fem.lanes` takes, comparisons and signs aside.
As a script it prints the counts as JSON; it needs NUMBA_DISABLE_JIT=1.
"""

import json
import operator
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

FUNCTIONS = {
    # guess, then per Newton step three products and a multiply-add
    "reciprocal_sqrt": {"float32": 1 + 3 * 5, "float64": 1 + 4 * 5},
    # k, two multiply-adds, Horner's rule of degree 6 or 12, product, 2^k - 1, multiply-add
    "expm1": {"float32": 1 + 4 + 12 + 1 + 3, "float64": 1 + 4 + 24 + 1 + 3},
    # s = (m - 1) / (m + 1) and its square, Horner's rule of degree 4 or 10, product, multiply-add
    "log": {"float32": 4 + 8 + 3, "float64": 4 + 20 + 3},
    "copysign": {"float32": 0, "float64": 0},
}
"""Operations of the functions of `softsample.fem.lanes`."""


def count() -> dict[str, int]:
    """Operations per element and step, by precision and kind of exponents, e.g. `float32 even`."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    printed = subprocess.run(
        [sys.executable, str(Path(__file__))], env=environment, check=True, capture_output=True
    ).stdout
    return json.loads(printed)


def _counted(precision: str, spectral: bool) -> int:
    """Operations of `forces.add_regular`, that of the benchmark's cuboid.

    Two Ogden terms, exponents -8 and 16 if even.
    """
    import numpy as np

    from softsample.constitutive.laws import ogden
    from softsample.constitutive.ogden import OgdenMaterial
    from softsample.fem import forces, stress, tensors
    from softsample.fem.explicit import JACOBI_SWEEPS, ExplicitModel, SolverSettings
    from softsample.meshing.cuboid import mesh_cuboid
    from softsample.meshing.mesh import HexMesh

    done: set[tuple[object, ...]] = set()
    functions = 0

    class Number(float):
        """A number that counts what is done with it."""

    def operation(name: str, swapped: bool) -> Callable[[Number, float], Number]:
        neutral = 0.0 if name in ("add", "sub") else 1.0

        def counting(self: Number, other: float) -> Number:
            a, b = (float(other), float(self)) if swapped else (float(self), float(other))
            if neutral not in (abs(a), abs(b)):
                done.add((name, a, b) if name in ("sub", "truediv") else (name, *sorted((a, b))))
            return Number(getattr(operator, name)(a, b))

        return counting

    for name in ("add", "sub", "mul", "truediv"):
        setattr(Number, f"__{name}__", operation(name, swapped=False))
        setattr(Number, f"__r{name}__", operation(name, swapped=True))

    def function(name: str, plain: Callable[..., float]) -> Callable[..., Number]:
        def counting(*args: float) -> Number:
            nonlocal functions
            functions += FUNCTIONS[name][precision]
            return Number(plain(*map(float, args)))

        return counting

    rng = np.random.default_rng(0)
    row = mesh_cuboid(8e-3, 1e-3, 1e-3, 1e-3)  # a block of parallelepipeds
    row = HexMesh(row.points @ (np.eye(3) + 0.1 * rng.random((3, 3))), row.hexes)
    one = HexMesh(row.points[row.hexes[0]], np.arange(8)[None])
    model = ExplicitModel(row, SolverSettings("scalar", "float64"))
    material = OgdenMaterial((1196.8, 113.1), (-8.0, 16.0), 0.49)
    u = 1e-4 * rng.standard_normal((len(row.points), 4))
    counting = np.vectorize(Number, otypes=[object])
    elements = model.elements(material.shear_modulus)
    elements = elements._replace(
        **{k: counting(v) for k, v in elements._asdict().items() if k != "connectivity"}
    )
    force, state = counting(np.zeros_like(u)), np.zeros((3, 1, 16))
    places = {"reciprocal_sqrt": tensors, "copysign": tensors, "log": stress, "expm1": ogden}
    originals = {name: getattr(place, name) for name, place in places.items()}
    for name, plain in originals.items():
        setattr(places[name], name, function(name, plain))
    solid = model.solid(material)._replace(sweeps=JACOBI_SWEEPS[precision] if spectral else 0)
    forces.add_regular(counting(u), elements, solid, None, None, force, state, False, 0, 0)
    for name, plain in originals.items():
        setattr(places[name], name, plain)
    corners = row.hexes[0]
    alone = ExplicitModel(one, model.settings)
    expected, _ = alone.internal_force(u[corners, :3], material)
    np.testing.assert_allclose(
        force[corners, :3].astype(float), expected, atol=1e-9 * np.abs(expected).max()
    )
    return len(done) + functions


if __name__ == "__main__":
    counts = {
        f"{precision} {'real' if spectral else 'even'}": _counted(precision, spectral)
        for precision in ("float32", "float64")
        for spectral in (False, True)
    }
    print(json.dumps(counts))
