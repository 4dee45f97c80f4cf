"""The same test in other finite element programs: CalculiX and felupe.

A clamped mesh, bottom nodes fixed, top nodes moved rigidly in equal increments; curves are
(n, 2): travel [m] and force on the platen's side [N] along it, from zero.
"""

import os
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import spmatrix
from scipy.sparse.linalg import splu

from softsample.arrays import Array
from softsample.constitutive.material import Material
from softsample.errors import InputError
from softsample.meshing.mesh import HexMesh
from softsample.protocol import DIRECTIONS


def versions_of_peers() -> dict[str, str]:
    """Versions of CalculiX and felupe, those that are installed."""
    found = {}
    if shutil.which("ccx"):
        text = subprocess.run(["ccx", "-v"], capture_output=True, text=True, check=False).stdout
        found["calculix"] = re.findall(r"[\d.]+", text)[0]
    try:
        import felupe
    except ImportError:
        return found
    return {**found, "felupe": felupe.__version__}


# --- CalculiX -----------------------------------------------------------------------------------


def calculix_deck(
    mesh: HexMesh,
    material: Material,
    travel: ArrayLike,
    increments: int,
    element: str = "C3D8R",
) -> str:
    """Input of CalculiX for a clamped mesh whose top moves by `travel` (3,) [m]; units mm, MPa."""
    nodes = [
        f"{i}, {x:.9g}, {y:.9g}, {z:.9g}" for i, (x, y, z) in enumerate(1e3 * mesh.points, start=1)
    ]
    elements = [
        ", ".join(map(str, (i, *(corners + 1)))) for i, corners in enumerate(mesh.hexes, start=1)
    ]
    # the compliance 1/D2 of the quartic volume term is as good as none
    constants = [
        *(1e-6 * value if k % 2 == 0 else value for pair in zip(material.mu, material.alpha,
          strict=True) for k, value in enumerate(pair)),
        2e6 / material.bulk_modulus,
        *[1e12] * (len(material.mu) - 1),
    ]  # fmt: skip
    moves = [f"TOP, {i}, {i}, {1e3 * d:.9g}" for i, d in enumerate(np.asarray(travel), start=1)]
    return "\n".join([
        "*NODE", *nodes,
        f"*ELEMENT, TYPE={element}, ELSET=ALL", *elements,
        "*NSET, NSET=BOTTOM", *map(str, mesh.bottom + 1),
        "*NSET, NSET=TOP", *map(str, mesh.glued(0.0) + 1),
        "*MATERIAL, NAME=TISSUE",
        f"*HYPERELASTIC, OGDEN, N={len(material.mu)}",
        ", ".join(f"{c:.9g}" for c in constants),
        "*SOLID SECTION, ELSET=ALL, MATERIAL=TISSUE",
        "*BOUNDARY", "BOTTOM, 1, 3, 0.0",
        "*STEP, NLGEOM, INC=1000", "*STATIC",
        f"{1 / increments:.9g}, 1.0, 1e-5, {1 / increments:.9g}",
        "*BOUNDARY", *moves,
        "*NODE PRINT, NSET=TOP, TOTALS=ONLY", "RF",
        "*END STEP", "",
    ])  # fmt: skip


def calculix(
    mesh: HexMesh, material: Material, mode: str, travel: float, increments: int = 10
) -> tuple[Array, float]:
    """Curve of one-point hexahedra C3D8R in CalculiX, one thread, and its CPU seconds.

    The program cuts increments that do not converge; every one that did is a row.
    """
    direction = np.array(DIRECTIONS[mode])
    with tempfile.TemporaryDirectory() as folder:
        deck = calculix_deck(mesh, material, travel * direction, increments)
        (Path(folder) / "test.inp").write_text(deck, encoding="ascii")
        before = os.times()
        subprocess.run(
            ["ccx", "test"], cwd=folder, check=False, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, env={**os.environ, "OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        after = os.times()
        printed = (Path(folder) / "test.dat").read_text(encoding="ascii")
    blocks = re.findall(r"time\s+(\S+)\s+([-+\d.E]+)\s+([-+\d.E]+)\s+([-+\d.E]+)", printed)
    rows = np.array([[0.0] * 4, *([float(x) for x in block] for block in blocks)])
    cpu = (after.children_user + after.children_system) - (
        before.children_user + before.children_system
    )
    return np.column_stack([rows[:, 0] * travel, rows[:, 1:] @ direction]), cpu


# --- felupe -------------------------------------------------------------------------------------


class IsochoricOgden:
    """Isochoric part of an Ogden solid for felupe: stress and tangent from singular values of F.

    With F = sum l_a u_a v_a the stress is P = sum W_a u_a v_a, and the tangent has, in the basis
    u_a v_b, the second derivatives W_ab and the divided differences of l_a W_a for the shears.

    References
    ----------
    R. W. Ogden, Non-linear elastic deformations, Ellis Horwood, 1984, section 6.1.4.
    """

    def __init__(self, material: Material) -> None:
        self.material = material
        self.x = [np.zeros((3, 3)), np.zeros(0)]
        self.density = None

    def _principal(self, F: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Bases u, v and stretches l, with l W_a and l_a l_b W_ab of points first."""
        u, stretch, vt = np.linalg.svd(np.moveaxis(F, (0, 1), (-2, -1)))
        isochoric = stretch * np.prod(stretch, axis=-1, keepdims=True) ** (-1 / 3)
        b, c = np.zeros_like(stretch), np.zeros_like(stretch)
        for mu, alpha in zip(self.material.mu, self.material.alpha, strict=True):
            b += 2.0 * mu / alpha * isochoric**alpha
            c += 2.0 * mu * isochoric**alpha
        first = b - b.mean(axis=-1, keepdims=True)
        trace_free = c - c.mean(axis=-1, keepdims=True)
        second = np.eye(3) * (c - first)[..., None, :]
        second -= (c[..., :, None] + trace_free[..., None, :]) / 3.0
        return u, stretch, np.swapaxes(vt, -1, -2), first, second

    def gradient(self, x: list, *args: object, **kwargs: object) -> list:
        """First Piola-Kirchhoff stress (3, 3, ...) and no state."""
        u, stretch, v, first, _ = self._principal(x[0])
        stress = (u * (first / stretch)[..., None, :]) @ np.swapaxes(v, -1, -2)
        return [np.ascontiguousarray(np.moveaxis(stress, (-2, -1), (0, 1))), x[-1]]

    def hessian(self, x: list, *args: object, **kwargs: object) -> list:
        """Tangent dP/dF (3, 3, 3, 3, ...)."""
        u, stretch, v, first, second = self._principal(x[0])
        slope = first / stretch
        rate = second / (stretch[..., :, None] * stretch[..., None, :])
        inner = np.zeros((*stretch.shape[:-1], 3, 3, 3, 3))
        for a in range(3):
            for b in range(3):
                inner[..., a, a, b, b] = rate[..., a, b]
                if a == b:
                    continue
                sums = stretch[..., a] + stretch[..., b]
                gap = stretch[..., a] - stretch[..., b]
                near = np.abs(gap) < 1e-6
                safe = np.where(near, 1.0, gap)
                minus = np.where(
                    near, rate[..., a, a] - rate[..., a, b], (slope[..., a] - slope[..., b]) / safe
                )
                plus = (slope[..., a] + slope[..., b]) / sums
                inner[..., a, b, a, b] = 0.5 * (minus + plus)
                inner[..., a, b, b, a] = 0.5 * (minus - plus)
        basis = np.einsum("...ia,...jb->...abij", u, v).reshape(*stretch.shape[:-1], 9, 9)
        tangent = np.swapaxes(basis, -1, -2) @ inner.reshape(basis.shape) @ basis
        tangent = tangent.reshape(*stretch.shape[:-1], 3, 3, 3, 3)
        return [np.ascontiguousarray(np.moveaxis(tangent, (-4, -3, -2, -1), (0, 1, 2, 3)))]


def symmetric_superlu(matrix: spmatrix, load: Array) -> Array:
    """SuperLU as it should be told of a symmetric matrix: several times faster than `spsolve`."""
    factors = splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )  # fmt: skip
    return factors.solve(load)


def felupe(
    mesh: HexMesh,
    material: Material,
    mode: str,
    travel: float,
    increments: int = 10,
    solver: Callable = symmetric_superlu,
) -> tuple[Array, float]:
    """Curve of mean-dilatation hexahedra in felupe and its CPU seconds."""
    import felupe as fem

    start = time.process_time()
    region = fem.RegionHexahedron(fem.Mesh(mesh.points, mesh.hexes, "hexahedron"))
    field = fem.FieldContainer([fem.Field(region, dim=3)])
    solid = fem.SolidBodyNearlyIncompressible(
        IsochoricOgden(material), field, bulk=material.bulk_modulus
    )
    direction, top = np.array(DIRECTIONS[mode]), mesh.glued(0.0)
    mask = np.isin(np.arange(len(mesh.points)), top)
    base = np.isin(np.arange(len(mesh.points)), mesh.bottom)
    bounds = {"base": fem.Boundary(field[0], mask=base)}
    for axis in range(3):
        skip = tuple(int(k != axis) for k in range(3))
        bounds[f"top{axis}"] = fem.Boundary(field[0], mask=mask, skip=skip)
    rows = [(0.0, 0.0)]
    for part in np.arange(1, increments + 1) / increments:
        for axis in range(3):
            bounds[f"top{axis}"].value = part * travel * direction[axis]
        dof0, dof1 = fem.dof.partition(field, bounds)
        ext0 = fem.dof.apply(field, bounds, dof0)
        result = fem.newtonraphson(
            items=[solid], dof0=dof0, dof1=dof1, ext0=ext0, solver=solver, tol=1e-6, verbose=0
        )
        force = fem.tools.force(field, result.fun, bounds["top0"])
        rows.append((part * travel, float(abs(force @ direction))))
    return np.array(rows), time.process_time() - start


def read_calculix_forces(path: Path, moved: str | None = None) -> tuple[Array, Array]:
    """Forces that a run of CalculiX printed.

    Parameters
    ----------
    path
        The `.dat` file beside the input.
    moved : str, optional
        Node set of the forces; the first one of the file by default. In torsion that is TURN,
        whose forces are moments [N mm], and AXIS has the forces.

    Returns
    -------
    time : (n,) float64
        Fraction of the travel, from zero (at rest, not in the file) upwards.
    force : (n, 3) float64
        Force of what moves on the sample [N].

    Raises
    ------
    InputError
        If the file holds no forces of the set: the run stopped in its first increment.
    """
    number = r"\s+([-+.\dE]+)"
    text = Path(path).read_text(encoding="utf-8")
    total = rf"total force .* for set (\S+) and time{number}{number}{number}{number}"
    found = re.findall(total, text)
    rows = [row for name, *row in found if name == (moved or found[0][0])]
    if not rows:
        raise InputError(f"{path}: holds no forces; look for *ERROR in what CalculiX printed")
    table = np.array([[0.0] * 4, *rows], dtype=np.float64)
    return table[:, 0], table[:, 1:]
