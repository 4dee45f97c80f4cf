"""Best node positions of a hexahedral mesh whose surface is pulled to a level set."""

from collections.abc import Callable
from dataclasses import dataclass

import numba
import numpy as np
from scipy.optimize import minimize

from softsample.arrays import Array, Ids, Mask
from softsample.meshing.mesh import CORNERS


@numba.njit(cache=True, error_model="numpy")
def shape_energy(
    points: Array, hexes: Ids, corners: Ids, volume_weight: float, barrier: float, gradient: Array
) -> float:
    """Distortion of all elements, and its gradient added to `gradient` (n, 3).

    At each corner with edges ``A = [a b c]`` (in units of the wanted edge), ``det`` replaced by
    ``D = (det + sqrt(det^2 + barrier^2)) / 2 > 0``:
    ``(|A|^2 / 3)^3 / D^2 - 1 + volume_weight ((D + 1 / D) / 2 - 1)``, averaged over the eight
    corners. The first term is the third power of the inverse mean ratio; a positive `barrier`
    lets inverted corners untangle.
    """
    total = 0.0
    for e in range(hexes.shape[0]):
        for q in range(8):
            n0 = hexes[e, corners[q, 0]]
            n1 = hexes[e, corners[q, 1]]
            n2 = hexes[e, corners[q, 2]]
            n3 = hexes[e, corners[q, 3]]
            x, y, z = points[n0, 0], points[n0, 1], points[n0, 2]
            ax, ay, az = points[n1, 0] - x, points[n1, 1] - y, points[n1, 2] - z
            bx, by, bz = points[n2, 0] - x, points[n2, 1] - y, points[n2, 2] - z
            cx, cy, cz = points[n3, 0] - x, points[n3, 1] - y, points[n3, 2] - z
            ux, uy, uz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
            vx, vy, vz = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
            wx, wy, wz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            det = ax * ux + ay * uy + az * uz
            norm = (
                ax * ax + ay * ay + az * az + bx * bx + by * by + bz * bz
                + cx * cx + cy * cy + cz * cz
            ) / 3.0  # fmt: skip
            root = np.sqrt(det * det + barrier * barrier)
            # the second form keeps digits where det is close to -barrier or below
            size = 0.5 * (det + root) if det > 0.0 else 0.5 * barrier * barrier / (root - det)
            inverse = 1.0 / size
            shape = norm * norm * norm * inverse * inverse
            total += shape - 1.0 + volume_weight * (0.5 * (size + inverse) - 1.0)
            by_size = -2.0 * shape * inverse + 0.5 * volume_weight * (1.0 - inverse * inverse)
            by_det = 0.125 * by_size * size / root
            by_edge = 0.125 * 2.0 * norm * norm * inverse * inverse
            gax, gay, gaz = (
                by_edge * ax + by_det * ux, by_edge * ay + by_det * uy, by_edge * az + by_det * uz
            )  # fmt: skip
            gbx, gby, gbz = (
                by_edge * bx + by_det * vx, by_edge * by + by_det * vy, by_edge * bz + by_det * vz
            )  # fmt: skip
            gcx, gcy, gcz = (
                by_edge * cx + by_det * wx, by_edge * cy + by_det * wy, by_edge * cz + by_det * wz
            )  # fmt: skip
            gradient[n1, 0] += gax
            gradient[n1, 1] += gay
            gradient[n1, 2] += gaz
            gradient[n2, 0] += gbx
            gradient[n2, 1] += gby
            gradient[n2, 2] += gbz
            gradient[n3, 0] += gcx
            gradient[n3, 1] += gcy
            gradient[n3, 2] += gcz
            gradient[n0, 0] -= gax + gbx + gcx
            gradient[n0, 1] -= gay + gby + gcy
            gradient[n0, 2] -= gaz + gbz + gcz
    return 0.125 * total


@dataclass(frozen=True)
class Stage:
    """One minimisation of the sequence; all without units, lengths in elements."""

    surface_weight: float
    barrier: float
    iterations: int


@dataclass(frozen=True, eq=False)
class Problem:
    """What stays the same while the nodes move; lengths in units of the element size.

    Parameters
    ----------
    hexes : (m, 8) int64
        Elements, VTK order.
    free : (n, 3) bool
        Coordinates that may change.
    surface : (k,) int64
        Nodes that are pulled to the surface.
    faces : (f, 4) int64
        Faces whose centres are pulled to it too: nodes alone would cut a sharp edge off.
    distance : callable
        Signed distance and gradient at points (n, 3): ``(n,), (n, 3)``.
    pins : (p,) int64, targets : (p, 3) float64
        Nodes that are pulled to a place of their own.
    volume_weight : float
        Weight of the volume term against the shape term.
    """

    hexes: Ids
    free: Mask
    surface: Ids
    faces: Ids
    distance: Callable[[Array], tuple[Array, Array]]
    pins: Ids
    targets: Array
    volume_weight: float

    def energy(self, points: Array, stage: Stage) -> tuple[float, Array]:
        """Objective and its gradient (n, 3) at `points` (n, 3); fixed coordinates have none."""
        gradient = np.zeros_like(points)
        total = shape_energy(
            points, self.hexes, CORNERS, self.volume_weight, stage.barrier, gradient
        )
        weight = stage.surface_weight
        if weight > 0.0:
            centres = points[self.faces].mean(axis=1)
            value, slope = self.distance(np.concatenate([points[self.surface], centres]))
            total += weight * float(value @ value)
            pull = 2.0 * weight * value[:, None] * slope
            gradient[self.surface] += pull[: len(self.surface)]
            np.add.at(gradient, self.faces, 0.25 * pull[len(self.surface) :, None])
            offset = points[self.pins] - self.targets
            total += weight * float(np.sum(offset * offset))
            gradient[self.pins] += 2.0 * weight * offset
        gradient[~self.free] = 0.0
        return total, gradient


def optimise(problem: Problem, points: Array, stage: Stage) -> Array:
    """Positions (n, 3) of least energy by L-BFGS, started from `points` (n, 3)."""
    free = problem.free

    def value_and_slope(x: Array) -> tuple[float, Array]:
        moved[free] = x
        total, gradient = problem.energy(moved, stage)
        return total, gradient[free]

    moved = points.copy()
    fit = minimize(
        value_and_slope,
        points[free],
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": stage.iterations, "maxfun": 2 * stage.iterations, "maxcor": 12},
    )
    moved[free] = fit.x
    return moved
