"""Slow, plain twins of the solver's kernels: one element, one node, one step at a time.

They follow the definitions in `docs/solver.md` and share no formula with those of `softsample.fem`:
a full Gauss rule instead of closed forms, singular values of F instead of matrix products,
hourglass shape vectors written out instead of fast sums. Everything is float64.
"""

from itertools import pairwise, product

import numpy as np

SIGNS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
     [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
)  # fmt: skip
FREE, BASE, PLATEN = 0, 1, 2


def shape_slopes(place):
    """(8, 3) derivatives of the trilinear shape functions at natural coordinates."""
    slopes = np.empty((8, 3))
    for a, sign in enumerate(SIGNS):
        factor = [1.0 + sign[k] * place[k] for k in range(3)]
        for j in range(3):
            rest = [factor[k] for k in range(3) if k != j]
            slopes[a, j] = sign[j] * rest[0] * rest[1] / 8.0
    return slopes


def mean_gradient(corners):
    """Element mean (8, 3) of the shape functions' gradients and the volume, 3x3x3 Gauss points."""
    places, weights = np.polynomial.legendre.leggauss(3)
    total, volume = np.zeros((8, 3)), 0.0
    for i, j, k in product(range(3), repeat=3):
        slopes = shape_slopes((places[i], places[j], places[k]))
        jacobian = corners.T @ slopes  # dX_i / dxi_j
        weight = weights[i] * weights[j] * weights[k] * np.linalg.det(jacobian)
        total += weight * slopes @ np.linalg.inv(jacobian)
        volume += weight
    return total / volume, volume


def hourglass_shapes(corners, gradient):
    """(4, 8) shape vectors of Flanagan and Belytschko: orthogonal to every linear field."""
    x, y, z = SIGNS.T
    patterns = np.array([y * z, z * x, x * y, x * y * z], dtype=float)
    return patterns - (patterns @ corners) @ gradient.T


def principal_energy(stretches, material):
    """Strain energy per volume of principal stretches (3,)."""
    J = np.prod(stretches)
    energy = 0.5 * material.bulk_modulus * (J - 1.0) ** 2
    for mu, alpha in zip(material.mu, material.alpha, strict=True):
        energy += 2.0 * mu / alpha**2 * (np.sum((J ** (-1 / 3) * stretches) ** alpha) - 3.0)
    return energy


def stress(F, material):
    """First Piola-Kirchhoff stress from the singular values of F and principal Cauchy stresses."""
    left, stretches, right = np.linalg.svd(F)
    if np.linalg.det(F) <= 0.0:
        raise ValueError("inverted")
    J = np.prod(stretches)
    cauchy = np.full(3, material.bulk_modulus * (J - 1.0))
    for mu, alpha in zip(material.mu, material.alpha, strict=True):
        power = (J ** (-1 / 3) * stretches) ** alpha
        cauchy += 2.0 * mu / (alpha * J) * (power - power.mean())
    return left @ np.diag(J * cauchy / stretches) @ right, principal_energy(stretches, material)


class Twin:
    """Internal forces of a mesh, element by element."""

    def __init__(self, mesh, hourglass_coefficient):
        self.mesh, self.coefficient = mesh, hourglass_coefficient
        self.parts = []
        for hexa in mesh.hexes:
            corners = mesh.points[hexa]
            B, volume = mean_gradient(corners)
            self.parts.append((hexa, B, volume, hourglass_shapes(corners, B)))

    def mass(self, density):
        """Lumped nodal masses: an eighth of every element."""
        mass = np.zeros(len(self.mesh.points))
        for hexa, _, volume, _ in self.parts:
            for node in hexa:
                mass[node] += density * volume / 8.0
        return mass

    def internal_force(self, u, material):
        """Forces (n, 3) and per element strain energy, hourglass energy, J - 1."""
        force = np.zeros_like(self.mesh.points)
        state = np.empty((3, len(self.parts)))
        for e, (hexa, B, volume, shapes) in enumerate(self.parts):
            F = np.eye(3) + u[hexa].T @ B
            P, density = stress(F, material)
            stiffness = self.coefficient * material.shear_modulus * volume * np.sum(B * B) / 64.0
            amplitudes = shapes @ u[hexa]  # (4, 3)
            element = volume * B @ P.T + stiffness * shapes.T @ amplitudes
            for a, node in enumerate(hexa):
                force[node] += element[a]
            state[:, e] = (
                volume * density,
                0.5 * stiffness * np.sum(amplitudes**2),
                np.linalg.det(F) - 1.0,
            )
        return force, state


def march(twin, material, boundary, path, dt, density):
    """Central differences with constant step; platens as in `softsample.fem.boundary.Boundary`.

    Returns displacements, velocities, holders, and per step the forces of platen and base (n, 6).
    """
    X, mass = twin.mesh.points, twin.mass(density)
    u, v = np.zeros_like(X), np.zeros_like(X)
    held, history = boundary.held.copy(), []
    for before, after in pairwise(path):
        internal, _ = twin.internal_force(u, material)
        velocity = boundary.direction * (after - before) / dt
        reaction = {BASE: np.zeros(3), PLATEN: np.zeros(3)}
        wanted = v - dt * internal / mass[:, None]
        for node in range(len(X)):
            holder = held[node]
            if holder == FREE:
                continue
            ruled = velocity if holder == PLATEN else np.zeros(3)
            push = mass[node] * (ruled - wanted[node]) / dt
            outward = boundary.planes[holder - 1, :3]
            touching = node in boundary.candidates
            if touching and boundary.release and push @ outward > 0.0:
                held[node] = FREE
                continue
            wanted[node] = ruled
            reaction[holder] = reaction[holder] + push
        v, start = wanted, u
        u = start + dt * v
        for node in boundary.candidates:
            if held[node] != FREE:
                continue
            for holder in (BASE, PLATEN):
                normal, offset = boundary.planes[holder - 1, :3], boundary.planes[holder - 1, 3]
                if holder == PLATEN:
                    offset = offset + after * (normal @ boundary.direction)
                beyond = (X[node] + u[node]) @ normal - offset
                if beyond > 0.0:
                    held[node] = holder
                    u[node] = u[node] - beyond * normal
                    stopped = (u[node] - start[node]) / dt
                    reaction[holder] = reaction[holder] + mass[node] * (stopped - v[node]) / dt
                    v[node] = stopped
                    break
        history.append(np.concatenate([reaction[PLATEN], reaction[BASE]]))
    return u, v, held, np.array(history)


def equilibrium(force_of, u, free, tolerance):
    """Newton's method with a dense tangent by differences: free nodes without residual force."""
    u, n = u.copy(), 3 * int(free.sum())
    reach = 1e-6 * np.abs(u).max()
    for _ in range(12):
        residual = force_of(u)[free].ravel()
        if np.abs(residual).max() < tolerance:
            return u
        tangent = np.empty((n, n))
        for k in range(n):
            step = np.zeros(n)
            step[k] = reach
            moved = u.copy()
            moved[free] += step.reshape(-1, 3)
            tangent[:, k] = (force_of(moved)[free].ravel() - residual) / reach
        u[free] -= np.linalg.solve(tangent, residual).reshape(-1, 3)
    raise AssertionError("no equilibrium found")


def stiffness(force_of, u, reach):
    """Dense tangent (3n, 3n) of forces by central differences."""
    n = u.size
    tangent = np.empty((n, n))
    for k in range(n):
        step = np.zeros(n)
        step[k] = reach
        step = step.reshape(u.shape)
        tangent[:, k] = (force_of(u + step) - force_of(u - step)).ravel() / (2.0 * reach)
    return tangent
