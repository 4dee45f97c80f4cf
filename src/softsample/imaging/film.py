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

from dataclasses import dataclass, replace

import numba
import numpy as np
from scipy import linalg
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist
from scipy.special import ndtr

from softsample.arrays import Array, Ids, Mask
from softsample.units import MM

BAND = (-1.2 * MM, 0.8 * MM)
"""Depth of the voxels that are fitted [m], from inside to outside."""

FINE = 0.16 * MM
"""Longest edge of the cells that a voxel is divided into [m]."""

MOST = 150_000
"""Voxels that are fitted at most; of more, so many are drawn."""

NEIGHBOURS = 8
"""Places that a voxel's values are interpolated from."""

ROUNDS = 15
"""Levenberg-Marquardt steps at most."""

REWEIGHTED = 3
"""Steps after which the voxels are weighted anew."""

CONVERGED = 0.005
"""Gain in minus twice the logarithm of the probability, per unknown, that ends the steps."""

LONGEST_STEP = 3.0
"""Largest change of an unknown in a step, in standard deviations of its prior."""

OUTLIER = 4.0
"""Residuals beyond this many standard deviations lose weight (Huber)."""

TYPICAL = 0.04 * MM
"""Median of the film's thickness before the image is seen [m]."""

BRIGHTNESS_SIGMA = 0.15
"""Standard deviation of the fluid's brightness over the tissue's, before the image is seen."""

MOST_SIGMAS = 2.0
"""Bound of the brightness on either side, in its standard deviations."""

STARTS = (0.25, 0.5, 1.0, 2.0)
"""Even films from which the search begins, over the typical one."""

UNEVEN = 0.65 / MM
"""Relative standard deviation of a film's thickness about the one found, per voxel edge [1/m].

Found on phantoms whose films vary by a third within millimetres: small voxels see it, large do not.
"""

SEEN = 10.0
"""Logarithm of the odds that show a film."""

EDGE_WIDTH = np.sqrt(20.0 / 12.0)
"""Width of a smooth edge over that of the straight one of the same second moment."""


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

    def precision(self, places: Array) -> tuple[Array, float]:
        """Inverse covariance (n, n) between `places` (n, 3) [m] in units of `local`, and half the
        logarithm of its determinant.
        """
        factor = linalg.cholesky(
            self.common**2 + np.exp(-cdist(places, places) / self.reach), lower=True
        )
        lower = linalg.lapack.dpotri(factor, lower=1)[0]
        return lower + np.tril(lower, -1).T, -float(np.sum(np.log(np.diag(factor))))


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
    texture : float
        Standard deviation of the tissue about its smooth level.
    area : float
        Of the surface that they lie about [m2].
    """

    depth: Array
    cell: float
    edge: float
    place: Array
    power: Array
    noise: Array
    texture: float
    area: float

    def spread(self, expected: Array | float) -> Array:
        """Standard deviation (n,) of `power` where the intensity `expected` (n,) is."""
        noise = 4.0 * self.noise**2 * (expected**2 + self.noise**2)
        return np.sqrt(noise + (2.0 * self.texture * expected**2) ** 2)

    def thinnest_film(self, brightness: float) -> float:
        """Thickness [m] of the thinnest film that these voxels show.

        A film of thickness t and r times the tissue's brightness adds ``r (r - 1) t**2`` to the
        second moment of the edge. That changes the voxels of a layer by half of it over the square
        of their edge.
        """
        noise = float(np.median(self.spread(0.5)))  # of the intensity as well: 2 * 0.5 is 1
        moment = 2.0 * self.edge**3 * noise * np.sqrt(2.0 * SEEN / self.area)
        return float(np.sqrt(moment / (brightness * (brightness - 1.0))))


@dataclass(frozen=True)
class Interpolation:
    """Means of the values at the nearest places of the surface.

    Attributes
    ----------
    which, weight : (n, k) int64 and float64
        Of the places taken at each point.
    """

    which: Ids
    weight: Array

    @classmethod
    def between(cls, places: Array, points: Array) -> "Interpolation":
        """From `places` (m, 3) to `points` (n, 3).

        The farthest place taken weighs nothing, so that it does not matter which of two equally
        far ones is taken.
        """
        count = min(NEIGHBOURS, len(places))
        found = cKDTree(places).query(points, k=count)
        away, which = (np.reshape(part, (len(points), count)) for part in found)
        weight = (1.0 - (away / (away[:, -1:] + 1e-12)) ** 2) ** 2 + 1e-9
        return cls(which, weight / weight.sum(axis=1, keepdims=True))

    def __call__(self, values: Array) -> Array:
        """Values (n,) at the points from those (m,) at the places."""
        return np.einsum("ij,ij->i", self.weight, values[self.which])


@dataclass(frozen=True)
class Fit:
    """Where the boundary is.

    Attributes
    ----------
    places : (m, 3) float64
        On the surface [m].
    shift, sigma : (m,) float64
        Way outward from the given surface to the boundary, and its standard deviation [m].
    film : float
        Mean thickness of the film [m]; zero without one.
    """

    places: Array
    shift: Array
    sigma: Array
    film: float

    def at(self, points: Array) -> tuple[Array, Array]:
        """Shift and its standard deviation (n,) at `points` (n, 3) [m]."""
        near = Interpolation.between(self.places, points)
        return near(self.shift), near(self.sigma)


def fit(voxels: Voxels, brightness: float) -> Fit:
    """Fit the boundary with a film and without one; a film is taken where the odds are for it.

    Both weight the voxels alike, by what the fit without film expects: their probabilities compare.

    Parameters
    ----------
    voxels : Voxels
        Near the surface.
    brightness : float
        Expected brightness of the fluid over that of the tissue.
    """
    wet = _Model.over(voxels, brightness)
    dry = wet.without_film()
    state = np.zeros(len(dry.precision))
    for rounds in (*[1] * REWEIGHTED, ROUNDS):
        spread = voxels.spread(dry.expected(state)[0])
        state = _descended(dry, spread, state, rounds)
    without = _Peak.at(dry, spread, state)
    starts = (wet.below_a_film(state, TYPICAL * share) for share in STARTS)
    start = min(starts, key=lambda start: wet.cost(spread, start))
    with_film = _Peak.at(wet, spread, _descended(wet, spread, start, ROUNDS))
    return (with_film if with_film.evidence > without.evidence + SEEN else without).fit()


@dataclass(frozen=True)
class _Model:
    """Fields over the surface, whitened: one standard deviation of the prior is 1.

    Attributes
    ----------
    voxels : Voxels
    priors, places : tuple of Prior, tuple of (m, 3) float64
        Shift, level and, with a film, the logarithm of its thickness.
    carry : tuple of Interpolation
        From places to voxels.
    precision : (u, u) float64
        Of the prior; with a film, its brightness is the last unknown.
    volumes : tuple of float
        Half the logarithm of the determinant of each field's part of it.
    brightness : float
        Expected.
    """

    voxels: Voxels
    priors: tuple[Prior, ...]
    places: tuple[Array, ...]
    carry: tuple[Interpolation, ...]
    precision: Array
    volumes: tuple[float, ...]
    brightness: float

    @classmethod
    def over(cls, voxels: Voxels, brightness: float) -> "_Model":
        """The model with a film."""
        priors = (SHIFT, LEVEL, FILM)
        places = tuple(_places(voxels, prior.patch) for prior in priors)
        blocks, volumes = zip(*map(Prior.precision, priors, places), strict=True)
        carry = tuple(Interpolation.between(place, voxels.place) for place in places)
        precision = linalg.block_diag(*blocks, np.eye(1))
        return cls(voxels, priors, places, carry, precision, volumes, brightness)

    def without_film(self) -> "_Model":
        """The same without film."""
        count = len(self.places[0]) + len(self.places[1])
        return replace(
            self,
            priors=self.priors[:2],
            places=self.places[:2],
            carry=self.carry[:2],
            precision=self.precision[:count, :count],
            volumes=self.volumes[:2],
        )

    @property
    def with_film(self) -> bool:
        return len(self.priors) == 3

    def below_a_film(self, state: Array, thickness: float) -> Array:
        """State with an even film whose half-maximum is that of a `state` without film."""
        even = np.full(len(self.places[2]), np.log(thickness / TYPICAL) / FILM.local)
        wet = np.concatenate([state, even, np.zeros(1)])
        wet[: len(self.places[0])] -= self.brightness * thickness / SHIFT.local
        return wet

    def values(self, state: Array) -> list[Array]:
        """Fields at their places."""
        parts = np.split(state, np.cumsum([len(place) for place in self.places]))
        return [prior.local * part for prior, part in zip(self.priors, parts, strict=False)]

    def ratio(self, state: Array) -> tuple[float, float]:
        """Brightness of the fluid, and its slope; bounded, or it were a shift by another name."""
        share = np.tanh(state[-1] / MOST_SIGMAS)
        ratio = self.brightness + BRIGHTNESS_SIGMA * MOST_SIGMAS * share
        return float(ratio), float(BRIGHTNESS_SIGMA * (1.0 - share**2))

    def expected(self, state: Array) -> tuple[Array, list[Array]]:
        """Expected intensity (n,) and its slopes by the fields and, with a film, by the state's
        brightness.
        """
        fields = [carry(part) for carry, part in zip(self.carry, self.values(state), strict=False)]
        level = 1.0 + fields[1]
        tissue, at_tissue = _share(self.voxels, fields[0])
        if not self.with_film:
            return level * tissue, [level * at_tissue, tissue]
        film, (ratio, at_ratio) = TYPICAL * np.exp(fields[2]), self.ratio(state)
        wet, at_wet = _share(self.voxels, fields[0] + film)
        signal = tissue + ratio * (wet - tissue)
        slopes = [
            level * (at_tissue + ratio * (at_wet - at_tissue)),
            signal,
            level * ratio * at_wet * film,
            level * (wet - tissue) * at_ratio,
        ]
        return level * signal, slopes

    def jacobian(self, slopes: list[Array]) -> tuple[Ids, Array]:
        """Unknowns that each voxel depends on, and the derivatives by them, (n, k)."""
        starts = np.cumsum([0, *(len(place) for place in self.places)])
        which = [carry.which + start for carry, start in zip(self.carry, starts, strict=False)]
        slope = [
            carry.weight * (prior.local * part)[:, None]
            for carry, prior, part in zip(self.carry, self.priors, slopes, strict=False)
        ]
        if self.with_film:
            which.append(np.full((len(slopes[3]), 1), starts[-1]))
            slope.append(slopes[3][:, None])
        return np.concatenate(which, axis=1), np.concatenate(slope, axis=1)

    def cost(self, spread: Array, state: Array) -> float:
        """Minus twice the logarithm of the probability of a state, but for a constant."""
        residual, far = self._residuals(spread, self.expected(state)[0])
        misfit = np.sum(residual**2 * (2.0 / far - 1.0 / far**2))
        return float(misfit + state @ self.precision @ state)

    def curvature(self, spread: Array, state: Array) -> tuple[Array, Array]:
        """Half the second derivative (u, u) of the cost, minus half the first (u,).

        The former is Gauss-Newton's; its lower half alone is filled.
        """
        expected, slopes = self.expected(state)
        residual, far = self._residuals(spread, expected)
        slope = 2.0 * expected / spread
        which, jacobian = self.jacobian([slope * part for part in slopes])
        hessian = self.precision.copy()
        descent = -self.precision @ state
        _add_products(which, jacobian, residual, 1.0 / far, hessian, descent)
        return hessian, descent

    def _residuals(self, spread: Array, expected: Array) -> tuple[Array, Array]:
        """Residuals in standard deviations, and how far beyond the bound of outliers."""
        residual = (self.voxels.power - expected**2) / spread
        return residual, np.maximum(np.abs(residual) / OUTLIER, 1.0)


@numba.njit(cache=True)
def _add_products(
    which: Ids, jacobian: Array, residual: Array, weight: Array, hessian: Array, descent: Array
) -> None:
    """Add J'WJ (lower half) to `hessian` and J'Wr to `descent`; J has the entries `which`."""
    for row in range(which.shape[0]):
        for a in range(which.shape[1]):
            i, left = which[row, a], weight[row] * jacobian[row, a]
            if left != 0.0:
                descent[i] += left * residual[row]
                for b in range(which.shape[1]):
                    j = which[row, b]
                    if j <= i:
                        hessian[i, j] += left * jacobian[row, b]


def _descended(model: _Model, spread: Array, state: Array, rounds: int) -> Array:
    """Most probable state, by damped Gauss-Newton steps (Levenberg-Marquardt)."""
    cost, damping = model.cost(spread, state), 0.0
    for _ in range(rounds):
        hessian, descent = model.curvature(spread, state)
        diagonal, gain = np.diag(hessian).copy(), -1.0
        while gain <= 0.0 and damping < 10.0:
            np.fill_diagonal(hessian, (1.0 + damping) * diagonal)
            step = linalg.cho_solve(linalg.cho_factor(hessian, lower=True), descent)
            step /= max(1.0, float(np.abs(step).max()) / LONGEST_STEP)
            gain = cost - model.cost(spread, state + step)
            damping = 0.3 * damping if gain > 0.0 else max(10.0 * damping, 0.1)
        if gain > 0.0:
            state, cost = state + step, cost - gain
        if gain < CONVERGED * len(state):
            break
    return state


@dataclass(frozen=True)
class _Peak:
    """Most probable state of a model, with the evidence by Laplace's approximation.

    Attributes
    ----------
    model : _Model
    state : (u,) float64
    factor : (u, u) float64
        Cholesky factor of the inverse covariance.
    evidence : float
        Logarithm of the probability of the image under the model, but for a constant.
    """

    model: _Model
    state: Array
    factor: Array
    evidence: float

    @classmethod
    def at(cls, model: _Model, spread: Array, state: Array) -> "_Peak":
        factor = linalg.cholesky(model.curvature(spread, state)[0], lower=True)
        occam = float(np.sum(np.log(np.diag(factor)))) - sum(model.volumes)
        return cls(model, state, factor, -0.5 * model.cost(spread, state) - occam)

    def fit(self) -> Fit:
        """Fields in metres."""
        shift, _, *film = self.model.values(self.state)
        places = self.model.places[0]
        covariance = linalg.lapack.dpotri(self.factor, lower=1)[0]
        variance = SHIFT.local**2 * np.diag(covariance)[: len(places)]
        if not film:
            ratio = self.model.brightness
            unseen = ratio * unseen_film(self.model.voxels.thinnest_film(ratio))
            return Fit(places, shift, np.sqrt(variance + unseen**2), 0.0)
        thickness, (ratio, _) = TYPICAL * np.exp(film[0]), self.model.ratio(self.state)
        carried = Interpolation.between(self.model.places[2], places)
        uneven = ratio * UNEVEN * self.model.voxels.edge * carried(thickness)
        return Fit(places, shift, np.sqrt(variance + uneven**2), float(thickness.mean()))


def unseen_film(thinnest: float) -> float:
    """Root of the mean square thickness [m] of a film that was not seen.

    Before the image is seen there is none, or one of a log-normal thickness, as likely as not. That
    it was not seen leaves those up to the `thinnest` [m].
    """
    sigma = float(np.hypot(FILM.common, 1.0)) * FILM.local
    reach = np.log(thinnest / TYPICAL) / sigma
    square = TYPICAL**2 * np.exp(2.0 * sigma**2) * ndtr(reach - 2.0 * sigma)
    return float(np.sqrt(square / (1.0 + ndtr(reach))))


def _places(voxels: Voxels, patch: float) -> Array:
    """Places (m, 3) about `patch` apart on the surface: means of what lies in each cube."""
    near = np.abs(voxels.depth.mean(axis=1)) < 0.3 * MM
    points = voxels.place[near]
    _, cube = np.unique(np.floor(points / patch), axis=0, return_inverse=True)
    count = np.bincount(cube.ravel())
    return np.stack([np.bincount(cube.ravel(), points[:, k]) / count for k in range(3)], axis=1)


def _share(voxels: Voxels, shift: Array) -> tuple[Array, Array]:
    """Share (n,) of each voxel inside the surface moved outward by `shift`; its slope.

    The edge of a cell is smooth, so that steps to the most probable shift do not meet kinks.
    """
    width = EDGE_WIDTH * voxels.cell
    height = np.clip(0.5 + (shift[:, None] - voxels.depth) / width, 0.0, 1.0)
    inside = np.mean(height**2 * (3.0 - 2.0 * height), axis=1)
    return inside, np.mean(6.0 * height * (1.0 - height), axis=1) / width


def voxels_near(
    power: Array,
    noise: Array,
    texture: float,
    usable: Mask,
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
    texture : float
        As of `Voxels`.
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
    area = len(index) * float(np.prod(edge)) / (BAND[1] - BAND[0])
    if len(index) > MOST:
        index = np.random.default_rng(0).choice(index, MOST, replace=False, shuffle=False)
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
        texture=texture,
        area=area,
    )
