"""Problems with known answers, for `tests/verification` and `benchmarks/verification.py`."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import brentq

from softsample.arrays import Array
from softsample.constitutive.material import Material
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import Boundary, ContactSettings, platen_boundary
from softsample.fem.element import CORNERS
from softsample.fem.explicit import ExplicitModel, Run, SolverSettings, _March
from softsample.fem.schedule import Schedule
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh
from softsample.protocol import History
from spectral import stress as ogden_stress

DOUBLE = SolverSettings(precision="float64")


def observed_orders(sizes: Sequence[float], errors: Sequence[float]) -> Array:
    """Order between neighbours: slope of log(error) over log(size), (n - 1,)."""
    return np.diff(np.log(np.abs(errors))) / np.diff(np.log(sizes))


def richardson(values: Sequence[float], ratio: float = 2.0) -> tuple[float, float]:
    """Order and limit of the last three values on meshes or in steps finer by `ratio` each.

    References
    ----------
    L. F. Richardson, Phil. Trans. R. Soc. Lond. A 210 (1911) 307, doi:10.1098/rsta.1911.0009.
    """
    coarse, middle, fine = values[-3:]
    order = float(np.log((coarse - middle) / (middle - fine)) / np.log(ratio))
    return order, float(fine + (fine - middle) / (ratio**order - 1.0))


def refined(mesh: HexMesh) -> HexMesh:
    """The same shape with each hexahedron split into eight at its trilinear midpoints."""
    parts = np.array([[i, j, k] for k in range(3) for j in range(3) for i in range(3)])
    shape = np.prod(1.0 + CORNERS * (parts[:, None] - 1.0), axis=2) / 8.0  # (27, 8)
    # a new node is known by the corners it lies between
    corners = np.sort(np.where(shape > 0.0, mesh.hexes[:, None, :], -1), axis=2)
    _, first, node = np.unique(
        corners.reshape(-1, 8), axis=0, return_index=True, return_inverse=True
    )
    points = (shape @ mesh.points[mesh.hexes]).reshape(-1, 3)[first]
    grid = node.reshape(-1, 27)
    lower = np.array([i + 3 * j + 9 * k for k in (0, 1) for j in (0, 1) for i in (0, 1)])
    around = np.array([0, 1, 4, 3, 9, 10, 13, 12])
    return HexMesh(points, grid[:, lower[:, None] + around].reshape(-1, 8).astype(np.int64))


# --- homogeneous compression --------------------------------------------------------------------


def homogeneous_stress(material: Material, stretch: float) -> float:
    """Nominal stress [Pa] along an axis of `stretch`, the sides free: one scalar equation."""

    def stress(side: float) -> Array:
        return ogden_stress(np.diag([side, side, stretch]), material)

    # sides that keep the volume are pulled, much narrower ones are pressed
    kept = stretch**-0.5
    side = brentq(lambda t: stress(t)[0, 0], 0.6 * kept, (1.0 + 1e-9) * kept, xtol=1e-14)
    return float(stress(side)[2, 2])


def smooth_platens(
    material: Material, settings: SolverSettings = DOUBLE, loading_time: float = 0.1
) -> tuple[Run, Array]:
    """Compression by 30 % between platens without friction, and the exact force [N] on its curve.

    The cuboid of 6 x 5 x 4 mm stays one, so that its 120 elements are as good as infinitely many.
    """
    edges = 6e-3, 5e-3, 4e-3
    mesh = mesh_cuboid(*edges, 1e-3)
    boundary = platen_boundary(mesh, ContactSettings(friction=0.0, base_friction=0.0))
    run = ExplicitModel(mesh, settings).run(
        material, boundary, 0.3 * edges[2], loading_time=loading_time
    )
    stress = [homogeneous_stress(material, 1.0 - d / edges[2]) for d in run.displacement]
    return run, -edges[0] * edges[1] * np.array(stress)


# --- vibration of a free square: orders in element size and time step ---------------------------


def lame_frequency(
    cells: int, step: float, poisson_ratio: float = 0.3, distortion: float = 0.0
) -> float:
    """Frequency of Lame's mode of a free square plate over the exact one, less one.

    u = (cos kx sin ky, -sin kx cos ky, 0), k = pi / L, on [0, L]^2 with free edges and faces
    vibrates with omega = sqrt(2) k sqrt(mu / rho): change of volume and all tractions vanish, so
    that neither Poisson's ratio nor the thickness matters. The plate is let go from rest and the
    first quarter of its period is timed.

    Parameters
    ----------
    cells : int
        Elements along an edge; an eighth of them, but two at least, through the thickness.
    step : float
        Time step in parts of the critical one.
    poisson_ratio : float
        Of the solid.
    distortion : float
        Random shift of the inner nodes by up to so many elements.

    References
    ----------
    K. F. Graff, Wave motion in elastic solids, Oxford 1975, section 8.1.
    """
    length, layers = 1e-2, max(2, cells // 8)
    block = mesh_cuboid(length, length, length * layers / cells, length / cells)
    inner = np.ones(len(block.points), bool)
    inner[block.boundary] = False
    shift = np.random.default_rng(1).uniform(-1.0, 1.0, block.points.shape) * inner[:, None]
    mesh = HexMesh(block.points + distortion * length / cells * shift, block.hexes)
    material = OgdenMaterial((1000.0,), (2.0,), poisson_ratio)
    model = ExplicitModel(mesh, DOUBLE)
    plate = _March(model, material, _free(mesh), Schedule(History.ramp(1.0), 1.0), None)
    k = np.pi / length
    x, y = k * (mesh.points[:, :2] + 0.5 * length).T
    mode = np.column_stack([np.cos(x) * np.sin(y), -np.sin(x) * np.cos(y), 0.0 * x])
    plate.motion.u[:, :3] = 1e-6 * length * mode
    dt = step * plate._critical_step()
    plate.dt = 1e-9 * dt  # no step before: the first kick is half a one
    weight = model.mass[:, None] * mode
    time, now = 0.0, float(np.sum(weight * plate.motion.u[:, :3]))
    while now > 0.0:
        plate._advance(np.array([time, time + dt]), dt)
        before, now = now, float(np.sum(weight * plate.motion.u[:, :3]))
        time += dt
    quarter = time - dt * now / (now - before)
    wave_speed = np.sqrt(material.shear_modulus / DOUBLE.density_kg_m3)
    return float(0.5 * np.pi / quarter / (np.sqrt(2.0) * k * wave_speed) - 1.0)


def _free(mesh: HexMesh) -> Boundary:
    """Nothing holds the mesh and no platen is near."""
    nowhere = np.array([[0.0, 0.0, -1.0, np.inf], [0.0, 0.0, 1.0, np.inf]])
    held = np.zeros(len(mesh.points), np.int8)
    return Boundary(held, np.empty(0, np.int32), nowhere, np.array([0.0, 0.0, 1.0]))


# --- virtual work of a large smooth deformation --------------------------------------------------


def virtual_work_error(cells: int, material: Material) -> float:
    """Relative error of the work of the internal forces on a smooth virtual displacement.

    Strains of the smooth field are up to 0.4; the exact integral of P : grad w over the unit cube
    is taken by Gauss' rule of 14 points an edge.
    """

    def field(X: Array) -> Array:
        x, y, z = X.T
        return 0.25 * np.column_stack([
            np.sin(x + 0.7 * z) * y, 0.6 * np.cos(1.3 * x) * z, np.sin(0.9 * y) * x - 0.5 * z
        ])  # fmt: skip

    def virtual(X: Array) -> Array:
        x, y, z = X.T
        return np.column_stack([np.sin(2.0 * x) * z, np.cos(y + x), z**2 * np.cos(1.5 * y)])

    def gradient(of: Callable[[Array], Array], X: Array) -> Array:
        reach = 1e-5
        steps = reach * np.eye(3)
        return np.stack([(of(X + e) - of(X - e)) / (2.0 * reach) for e in steps], axis=-1)

    place, weight = np.polynomial.legendre.leggauss(14)
    X = 0.5 * np.stack(np.meshgrid(*[place] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    X[:, 2] += 0.5
    weights = np.einsum("i,j,k->ijk", *[0.5 * weight] * 3).ravel()
    stress = ogden_stress(np.eye(3) + gradient(field, X), material)
    exact = float(np.einsum("n,nij,nij->", weights, stress, gradient(virtual, X)))
    mesh = mesh_cuboid(1.0, 1.0, 1.0, 1.0 / cells)
    force, _ = ExplicitModel(mesh, DOUBLE).internal_force(field(mesh.points), material)
    return float(np.sum(force * virtual(mesh.points))) / exact - 1.0


# --- Hertz: a flat platen on a paraboloid ---------------------------------------------------------


def _graded(cells: int, reach: float, finest: float) -> Array:
    """Coordinates from 0 to `reach` (cells + 1,), the first cell of width `finest`, growing on."""
    growth = brentq(
        lambda q: finest * (q**cells - 1.0) / (q - 1.0) - reach, 1.0 + 1e-9, 3.0, xtol=1e-14
    )
    return finest * (growth ** np.arange(cells + 1) - 1.0) / (growth - 1.0)


def paraboloid(radius: float, finest: float, reach: float, cells: int) -> HexMesh:
    """Block of 2 reach x 2 reach x reach [m] whose top falls as r^2 / (2 radius) near its middle.

    Elements grow from `finest` [m] at the top's middle outwards and downwards. Far out, where it
    matters no more, the top levels off.
    """
    block = mesh_cuboid(2.0 * cells, 2.0 * cells, 1.0 * cells, 1.0)
    line = _graded(cells, reach, finest)
    x, y = (np.sign(c) * line[np.abs(np.rint(c)).astype(int)] for c in block.points[:, :2].T)
    depth = line[cells - np.rint(block.points[:, 2]).astype(int)]
    fall = (x**2 + y**2) / (2.0 * radius)
    fall /= 1.0 + fall / (0.1 * reach)
    z = (reach - depth) * (1.0 - fall / reach)
    return HexMesh(np.column_stack([x, y, z]), block.hexes)


def hertz_force(material: Material, radius: float, height: float, depth: Array) -> Array:
    """Force [N] of a smooth rigid plane pressed by `depth` [m] on an elastic paraboloid.

    The paraboloid stands on a layer of `height` [m] bonded to its base: Hertz' formula times a
    series in contact radius over height.

    References
    ----------
    K. L. Johnson, Contact mechanics, Cambridge 1985, section 4.2.
    E. K. Dimitriadis et al., Biophys. J. 82 (2002) 2798, doi:10.1016/S0006-3495(02)75620-8.
    """
    nu = material.poisson_ratio
    stiffness = 2.0 * material.shear_modulus / (1.0 - nu)  # E / (1 - nu^2)
    a = -(1.2876 - 1.4678 * nu + 1.3442 * nu**2) / (1.0 - nu)
    b = (0.6387 - 1.0277 * nu + 1.5164 * nu**2) / (1.0 - nu)
    x = 2.0 / np.pi * np.sqrt(radius * np.asarray(depth)) / height
    layer = 1.0 - a * x + (a * x) ** 2 - (a**3 + 4.0 * np.pi**2 / 15.0 * b) * x**3
    layer += a * (a**3 + 0.6 * np.pi**2 * b) * x**4
    return 4.0 / 3.0 * stiffness * np.sqrt(radius) * np.asarray(depth) ** 1.5 * layer


def hertz(per_radius: int, cells: int, loading_time: float = 0.3) -> tuple[Run, Array]:
    """Contact up to a twentieth of the paraboloid's radius, and the exact force on its curve [N].

    Parameters
    ----------
    per_radius : int
        Elements along the largest contact radius.
    cells : int
        Elements along half an edge of the block, 12 contact radii.
    loading_time : float
        Solver time [s].
    """
    radius, contact = 20e-3, 1e-3
    material = OgdenMaterial((1000.0,), (2.0,), 0.3)
    height = 12.0 * contact
    mesh = paraboloid(radius, contact / per_radius, height, cells)
    boundary = platen_boundary(mesh, ContactSettings(friction=0.0, side_walls=False))
    run = ExplicitModel(mesh, DOUBLE).run(
        material, boundary, contact**2 / radius, loading_time=loading_time
    )
    return run, hertz_force(material, radius, height, run.displacement)
