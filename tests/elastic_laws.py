"""Solids of every elastic law, any of them in felupe, and the solver by eigenvalues alone."""

from types import SimpleNamespace

import numpy as np
from scipy.sparse import csr_matrix

import naive
from softsample.constitutive.material import Material, Term
from softsample.fem.explicit import JACOBI_SWEEPS, ExplicitModel
from softsample.protocol import DIRECTIONS
from spectral import stress

SHAPES = {
    "neo_hooke": [()],
    "mooney_rivlin": [(0.0,), (0.3,), (1.0,)],
    "yeoh": [(0.0, 0.0), (3.0, 8.0)],
    "gent": [(0.8,), (30.0,)],
    "exponential_i1": [(0.0,), (6.0,)],
    "exponential_i2": [(0.0,), (6.0,)],
    "ogden": [(-45.0,), (-8.0,), (-0.3,), (0.0,), (1e-3,), (2.0,), (7.3,), (40.0,)],
    "foam": [(-8.0, 0.2), (0.0, 0.3), (2.0, 0.0), (9.5, 0.0), (12.0, 0.49)],
}
SLANT = (0.3, -0.5, 0.8)
FIBRES = [
    Term("fibre", 300.0, shape, SLANT)
    for shape in ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (4.0, 0.15, 0.4))
]
SOLIDS = [
    *(
        Material((Term(law, 900.0, shape),), nu)
        for law, shapes in SHAPES.items()
        for shape in shapes
        for nu in ((0.0, 0.49) if law != "foam" else (shape[1],))
    ),
    *(Material((Term("neo_hooke", 700.0), fibre), 0.45) for fibre in FIBRES),
    Material((Term("ogden", 500.0, (-6.0,)), Term("exponential_i1", 200.0, (5.0,)), *FIBRES), 0.3),
    Material((Term("foam", 500.0, (6.0, 0.1)), Term("yeoh", 200.0, (1.0, 2.0))), 0.4),
]

TYPICAL = {
    "neo_hooke": Material((Term("neo_hooke", 900.0),), 0.45),
    "mooney_rivlin": Material((Term("mooney_rivlin", 900.0, (0.6,)),), 0.45),
    "yeoh": Material((Term("yeoh", 900.0, (2.0, 5.0)),), 0.45),
    "gent": Material((Term("gent", 900.0, (0.8,)),), 0.45),
    "exponential_i1": Material((Term("exponential_i1", 900.0, (4.0,)),), 0.45),
    "exponential_i2": Material((Term("exponential_i2", 900.0, (4.0,)),), 0.45),
    "ogden": Material((Term("ogden", 600.0, (-7.3,)), Term("ogden", 300.0, (0.0,))), 0.45),
    "foam": Material((Term("foam", 900.0, (8.0, 0.25)),), 0.25),
    "fibre": Material(
        (Term("neo_hooke", 900.0), Term("fibre", 400.0, (2.0, 0.1, 0.0), (0.0, 0.0, 1.0))), 0.45
    ),
}
"""One solid of every law, as tests by finite elements take it."""

CORK = Material((Term("foam", 900.0, (8.0, 0.0)),), 0.0)
"""Foam that does not bulge."""


class BySpectrum(ExplicitModel):
    """The solver by eigenvalues, for even exponents too, which it takes by products."""

    def solid(self, material):
        return super().solid(material)._replace(sweeps=JACOBI_SWEEPS[self.settings.precision])


def named(solid):
    terms = (f"{t.law}{','.join(f'{s:g}' for s in t.shape)}" for t in solid.terms)
    return f"{'+'.join(terms)} nu {solid.poisson_ratio:g}"


class LawOfFelupe:
    """Stress and tangent of a solid, as felupe asks for them."""

    def __init__(self, material):
        self.material = material
        self.x = [np.zeros((3, 3)), np.zeros(0)]

    def _stress(self, F):
        return stress(np.moveaxis(F, (0, 1), (-2, -1)), self.material)

    def gradient(self, x, *args, **kwargs):
        return [np.ascontiguousarray(np.moveaxis(self._stress(x[0]), (-2, -1), (0, 1))), x[-1]]

    def hessian(self, x, *args, **kwargs):
        """By central differences: Newton's iteration asks no more."""
        tangent, reach = np.empty((3, 3, *x[0].shape)), 1e-6
        for k in range(3):
            for m in range(3):
                step = np.zeros_like(x[0])
                step[k, m] = reach
                slope = (self._stress(x[0] + step) - self._stress(x[0] - step)) / (2.0 * reach)
                tangent[:, :, k, m] = np.moveaxis(slope, (-2, -1), (0, 1))
        return [tangent]


class HourglassOfFelupe:
    """The solver's hourglass stiffness as an item of felupe, from the plain twin's patterns."""

    def __init__(self, field, mesh, stiffness):
        blocks, rows, columns = [], [], []
        for hexa in mesh.hexes:
            B, volume = naive.mean_gradient(mesh.points[hexa])
            shapes = naive.hourglass_shapes(mesh.points[hexa], B)
            block = stiffness * volume * np.sum(B * B) / 64.0 * shapes.T @ shapes
            for axis in range(3):
                blocks.append(block.ravel())
                rows.append(np.repeat(3 * hexa + axis, 8))
                columns.append(np.tile(3 * hexa + axis, 8))
        place = np.concatenate(rows), np.concatenate(columns)
        size = mesh.points.size
        self.matrix = csr_matrix((np.concatenate(blocks), place), (size, size))
        self.field, self.results = field, SimpleNamespace(update_statevars=lambda: None)
        self.assemble = SimpleNamespace(
            vector=self._vector, matrix=lambda *args, **kwargs: self.matrix.copy(), multiplier=None
        )

    def _vector(self, field=None, **kwargs):
        return csr_matrix(self.matrix @ (field or self.field)[0].values.reshape(-1, 1))


def felupe_force(mesh, material, mode, travel, hourglass=0.5, increments=4):
    """Force [N] of a bonded block at the travel [m], by hexahedra of one point in felupe."""
    import felupe as fem

    region = fem.RegionHexahedron(
        fem.Mesh(mesh.points, mesh.hexes, "hexahedron"),
        quadrature=fem.GaussLegendre(order=0, dim=3),
    )
    field = fem.FieldContainer([fem.Field(region, dim=3)])
    items = [
        fem.SolidBody(LawOfFelupe(material), field),
        HourglassOfFelupe(field, mesh, hourglass * material.shear_modulus),
    ]
    direction, nodes = np.array(DIRECTIONS[mode]), np.arange(len(mesh.points))
    top = np.isin(nodes, mesh.glued(0.0))
    bounds = {"base": fem.Boundary(field[0], mask=np.isin(nodes, mesh.bottom))}
    for axis in range(3):
        skip = tuple(int(k != axis) for k in range(3))
        bounds[f"top{axis}"] = fem.Boundary(field[0], mask=top, skip=skip)
    for part in np.arange(1, increments + 1) / increments:
        for axis in range(3):
            bounds[f"top{axis}"].value = part * travel * direction[axis]
        dof0, dof1 = fem.dof.partition(field, bounds)
        ext0 = fem.dof.apply(field, bounds, dof0)
        result = fem.newtonraphson(
            items=items, dof0=dof0, dof1=dof1, ext0=ext0, tol=1e-6, verbose=0
        )
    return float(abs(fem.tools.force(field, result.fun, bounds["top0"]) @ direction))
