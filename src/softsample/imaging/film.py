"""Where tissue ends below a film of fluid: a model of the scanner, fitted to the voxels.

A film much thinner than a voxel moves the half-maximum outward by its thickness times its
brightness, and sharpens the edge. The sharpening tells film from tissue, but so faintly that one
place alone does not show it. The shift of the boundary, the thickness of the film and the level of
the tissue are therefore fields over the surface, smooth by their priors, and estimated together:
maximum a posteriori by Gauss-Newton steps. The derivation is in ``docs/geometry.md``.

References
----------
.. [1] A. Tarantola, Inverse problem theory, SIAM 2005, doi:10.1137/1.9780898717921, chapter 3.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

Array = NDArray[np.float64]

MM = 1e-3
"""One millimetre [m]."""

BAND = (-1.2 * MM, 0.8 * MM)
"""Depth of the voxels that are fitted [m], from inside to outside."""

FINE = 0.16 * MM
"""Longest edge of the cells that a voxel is divided into [m]."""

NEIGHBOURS = 8
"""Places that a voxel's values are interpolated from."""

ROUNDS = 12
"""Gauss-Newton steps at most."""

CONVERGED = 0.5
"""Change of minus twice the logarithm of the probability that ends the steps."""

LONGEST_STEP = 3.0
"""Largest change of an unknown in a step, in standard deviations of its prior."""

OUTLIER = 4.0
"""Residuals beyond this many standard deviations lose weight (Huber)."""

TEXTURE = 0.04
"""Standard deviation of the tissue about its smooth level."""

TYPICAL = 0.04 * MM
"""Median of the film's thickness before the image is seen [m]."""

BRIGHTNESS_SIGMA = 0.15
"""Standard deviation of the fluid's brightness over the tissue's, before the image is seen."""


MOST_SIGMAS = 2.0
"""Bound of the brightness on either side, in its standard deviations."""

UNRESOLVED = 0.25
"""Standard deviation of a film's thickness within a patch, relative."""

UNSEEN = 0.02
"""Standard deviation of the shift by a film too thin to be seen, in voxel edges."""


@dataclass(frozen=True)
class Prior:
    """What is expected of a field over the surface before the image is seen.

    Attributes
    ----------
    common : float
        Standard deviation of its mean over the sample, in units of `local`.
    local : float
        Standard deviation about that mean.
    reach : float
        Distance over which it forgets itself [m].
    patch : float
        Distance of the places that carry it [m].
    """

    common: float
    local: float
    reach: float
    patch: float

    def precision(self, places: Array) -> Array:
        """Inverse covariance (n, n) between `places` (n, 3) [m] in units of `local`."""
        near = np.exp(-cdist(places, places) / self.reach)
        return np.asarray(np.linalg.inv(self.common**2 + near))


SHIFT = Prior(5.0, 0.04 * MM, 3.0 * MM, 1.1 * MM)
"""Of the boundary outward [m]."""

FILM = Prior(3.0, 0.3, 4.0 * MM, 2.0 * MM)
"""Logarithm of the film's thickness over `TYPICAL`."""

LEVEL = Prior(1.0, 0.05, 3.0 * MM, 2.0 * MM)
"""Of the tissue, relative to that of the segmentation."""


@dataclass(frozen=True)
class Voxels:
    """Voxels near a surface.

    Attributes
    ----------
    depth : (n, q) float64
        Signed distance of the cells of each voxel to the surface [m], negative inside.
    cell, edge : float
        Edge of a cell; geometric mean of the voxel's edges [m].
    place : (n, 3) float64
        Centres in the sample frame [m].
    power, noise : (n,) float64
        Square of the intensity over that of tissue, less that of the noise; standard deviation
        of the noise. Squares, since the mean of a magnitude's square is exact at any noise.
    """

    depth: Array
    cell: float
    edge: float
    place: Array
    power: Array
    noise: Array


@dataclass(frozen=True)
class Field:
    """Values at places of the surface.

    Attributes
    ----------
    places : (m, 3) float64
        Sample frame [m].
    values : (m,) float64
    """

    places: Array
    values: Array

    def __call__(self, points: Array) -> Array:
        """Values (n,) at `points` (n, 3) [m]."""
        return np.asarray(_weights(self.places, points) @ self.values)


@dataclass(frozen=True)
class Fit:
    """Where the boundary is.

    Attributes
    ----------
    shift, sigma : Field
        Way outward from the given surface to the boundary, and its standard deviation [m].
    film : Field
        Thickness of the film [m]; zero without one.
    brightness : float
        Of the fluid over the tissue.
    evidence : float
        Logarithm of the probability of the image under this model, but for a constant.
    """

    shift: Field
    sigma: Field
    film: Field
    brightness: float
    evidence: float


def fit(voxels: Voxels, brightness: float) -> Fit:
    """Fit the boundary with a film and without one; the more probable model is taken.

    Parameters
    ----------
    voxels : Voxels
        Near the surface.
    brightness : float
        Expected brightness of the fluid over that of the tissue.
    """
    dry, wet = (_fit(voxels, brightness, film) for film in (False, True))
    return wet if wet.evidence > dry.evidence else dry


@dataclass(frozen=True)
class _Unknowns:
    """Fields of a model, whitened: one standard deviation of the prior is 1.

    Attributes
    ----------
    priors, places : tuple of Prior, tuple of (m, 3) float64
        Shift, level and, with a film, the logarithm of its thickness.
    carry : tuple of (n, m) sparse
        From places to voxels.
    precision : (u, u) float64
        Of the prior; with a film, its brightness is the last unknown.
    brightness : float
        Expected.
    """

    priors: tuple[Prior, ...]
    places: tuple[Array, ...]
    carry: tuple[Any, ...]
    precision: Array
    brightness: float

    @classmethod
    def over(cls, voxels: Voxels, brightness: float, with_film: bool) -> "_Unknowns":
        priors = (SHIFT, LEVEL, FILM) if with_film else (SHIFT, LEVEL)
        places = tuple(_places(voxels, prior.patch) for prior in priors)
        blocks = [prior.precision(place) for prior, place in zip(priors, places, strict=True)]
        return cls(
            priors,
            places,
            tuple(_weights(place, voxels.place) for place in places),
            linalg.block_diag(*blocks, *([np.eye(1)] if with_film else [])),
            brightness,
        )

    @property
    def with_film(self) -> bool:
        return len(self.priors) == 3

    def start(self) -> Array:
        """No shift without a film; with one, that of a film of typical thickness."""
        state = np.zeros(len(self.precision))
        if self.with_film:
            state[: len(self.places[0])] = -self.brightness * TYPICAL / SHIFT.local
        return state

    def values(self, state: Array) -> list[Array]:
        """Fields at their places."""
        ends = np.cumsum([len(place) for place in self.places])
        parts = np.split(state, ends)
        return [prior.local * part for prior, part in zip(self.priors, parts, strict=False)]

    def ratio(self, state: Array) -> float:
        """Brightness of the fluid."""
        return self.brightness + (BRIGHTNESS_SIGMA * float(state[-1]) if self.with_film else 0.0)

    def expected(self, voxels: Voxels, state: Array) -> tuple[Array, Any]:
        """Expected intensity (n,) and its derivative (n, u) by the state."""
        fields = [carry @ part for carry, part in zip(self.carry, self.values(state), strict=True)]
        film = TYPICAL * np.exp(fields[2]) if self.with_film else np.zeros(len(fields[0]))
        level, ratio = 1.0 + fields[1], self.ratio(state)
        tissue, at_tissue = _share(voxels, fields[0])
        wet, at_wet = _share(voxels, fields[0] + film)
        expected = level * (tissue + ratio * (wet - tissue))
        slopes = [
            level * (at_tissue + ratio * (at_wet - at_tissue)),
            expected / level,
            level * ratio * at_wet * film,
        ]
        columns: list[Any] = [
            carry.multiply((prior.local * slope)[:, None])
            for carry, prior, slope in zip(self.carry, self.priors, slopes, strict=False)
        ]
        if self.with_film:
            columns.append(BRIGHTNESS_SIGMA * (level * (wet - tissue))[:, None])
        return expected, sparse.hstack(columns).tocsr()


def _fit(voxels: Voxels, brightness: float, with_film: bool) -> Fit:
    """Most probable fields (Gauss-Newton), with the evidence by Laplace's approximation."""
    unknowns = _Unknowns.over(voxels, brightness, with_film)
    state, before = unknowns.start(), np.inf
    for _ in range(ROUNDS):
        cost, hessian, descent = _normal_equations(voxels, unknowns, state)
        factor = linalg.cho_factor(hessian)
        if abs(before - cost) < CONVERGED:
            break
        before = cost
        step = linalg.cho_solve(factor, descent)
        state = state + step / max(1.0, float(np.abs(step).max()) / LONGEST_STEP)
        if with_film:  # a fluid as bright as tissue would be a shift by another name
            state[-1] = np.clip(state[-1], -MOST_SIGMAS, MOST_SIGMAS)
    occam = 2.0 * np.sum(np.log(np.diag(factor[0]))) - np.linalg.slogdet(unknowns.precision)[1]
    values, place = unknowns.values(state), unknowns.places[0]
    film = Field(place, np.zeros(len(place)))
    if with_film:
        film = Field(unknowns.places[2], TYPICAL * np.exp(values[2]))
    covariance = linalg.cho_solve(factor, np.eye(len(state)))[: len(place), : len(place)]
    unseen = UNRESOLVED * unknowns.ratio(state) * film(place) if with_film else UNSEEN * voxels.edge
    return Fit(
        shift=Field(place, values[0]),
        sigma=Field(place, np.sqrt(SHIFT.local**2 * np.diag(covariance) + unseen**2)),
        film=film,
        brightness=unknowns.ratio(state),
        evidence=-0.5 * (cost + float(occam)),
    )


def _normal_equations(
    voxels: Voxels, unknowns: _Unknowns, state: Array
) -> tuple[float, Array, Array]:
    """Minus twice the logarithm of the probability, half its second and minus half its first
    derivative (Gauss-Newton), of the squares of the intensities.
    """
    expected, jacobian = unknowns.expected(voxels, state)
    sigma = np.sqrt(
        4.0 * voxels.noise**2 * (expected**2 + voxels.noise**2) + (2.0 * TEXTURE * expected**2) ** 2
    )
    residual = (voxels.power - expected**2) / sigma
    far = np.maximum(np.abs(residual) / OUTLIER, 1.0)
    cost = np.sum(residual**2 * (2.0 / far - 1.0 / far**2) + 2.0 * np.log(sigma))
    jacobian = jacobian.multiply((2.0 * expected / sigma)[:, None]).tocsr()
    weighted = jacobian.multiply((1.0 / far)[:, None]).T.tocsr()
    pull = unknowns.precision @ state
    hessian = (weighted @ jacobian).toarray() + unknowns.precision
    return float(cost + state @ pull), hessian, weighted @ residual - pull


def _places(voxels: Voxels, patch: float) -> Array:
    """Places (m, 3) about `patch` apart on the surface: means of what lies in each cube."""
    near = np.abs(voxels.depth.mean(axis=1)) < 0.3 * MM
    points = voxels.place[near]
    _, cube = np.unique(np.floor(points / patch), axis=0, return_inverse=True)
    count = np.bincount(cube.ravel())
    return np.stack([np.bincount(cube.ravel(), points[:, k]) / count for k in range(3)], axis=1)


def _weights(places: Array, points: Array) -> Any:
    """Weights (n, m) that carry values at `places` (m, 3) to `points` (n, 3).

    The farthest place taken weighs nothing, so that it does not matter which of two equally far
    ones is taken.
    """
    count = min(NEIGHBOURS, len(places))
    found = cKDTree(places).query(points, k=count)
    away, which = (np.reshape(part, (len(points), count)) for part in found)
    weight = (1.0 - (away / (away[:, -1:] + 1e-12)) ** 2) ** 2 + 1e-9
    weight /= weight.sum(axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(points)), count)
    shape = (len(points), len(places))
    return sparse.csr_matrix((weight.ravel(), (rows, which.ravel())), shape=shape)


def _share(voxels: Voxels, shift: Array) -> tuple[Array, Array]:
    """Share (n,) of each voxel inside the surface moved outward by `shift`; its slope."""
    height = 0.5 + (shift[:, None] - voxels.depth) / voxels.cell
    inside = np.clip(height, 0.0, 1.0).mean(axis=1)
    slope = np.mean((height > 0.0) & (height < 1.0), axis=1) / voxels.cell
    return inside, slope


def voxels_near(
    power: Array,
    noise: Array,
    usable: NDArray[np.bool_],
    distance: Array,
    origin: Array,
    spacing: float,
    to_sample: Array,
) -> Voxels:
    """Voxels near a surface, with the depth of their cells.

    Parameters
    ----------
    power, noise : (nx, ny, nz) float64
        As of `Voxels`, on the grid of the image.
    usable : (mx, my, mz) bool
        Where voxels may be taken, on the grid of `distance`.
    distance : (mx, my, mz) float64
        Signed distance to the surface [m], sample frame.
    origin : (3,) float64
        Position of ``distance[0, 0, 0]`` [m].
    spacing : float
        Of the grid of `distance` [m].
    to_sample : (4, 4) float64
        From voxel index to the sample frame [m].
    """
    matrix = to_sample[:3, :3] / spacing
    first = (to_sample[:3, 3] - origin) / spacing

    def looked_up(field: Array, index: Array, outside: float) -> Array:
        place = matrix @ index.T + first[:, None]
        return np.asarray(map_coordinates(field, place, order=1, cval=outside))

    index = np.indices(power.shape).reshape(3, -1).T.astype(np.float64)
    depth = looked_up(distance, index, 1.0)
    index = index[(depth > BAND[0]) & (depth < BAND[1])]
    index = index[looked_up(usable.astype(np.float64), index, 0.0) > 0.99]
    edge = np.linalg.norm(to_sample[:3, :3], axis=0)
    parts = np.ceil(edge / FINE - 1e-6).astype(int)
    steps = [(np.arange(n) + 0.5) / n - 0.5 for n in parts]
    cells = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    return Voxels(
        depth=np.stack([looked_up(distance, index + cell, 1.0) for cell in cells], axis=1),
        cell=float(np.max(edge / parts)),
        edge=float(np.prod(edge) ** (1.0 / 3.0)),
        place=index @ to_sample[:3, :3].T + to_sample[:3, 3],
        power=power[tuple(index.astype(np.int64).T)],
        noise=noise[tuple(index.astype(np.int64).T)],
    )
