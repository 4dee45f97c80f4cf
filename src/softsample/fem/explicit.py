"""Explicit total-Lagrangian dynamics of one test: public face of the solver."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal

from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import SimulationError
from softsample.fem import kernels
from softsample.fem.boundary import Boundary
from softsample.fem.denormals import flushed_denormals
from softsample.fem.element import hex_geometry, lumped_mass
from softsample.meshing.mesh import HexMesh
from softsample.protocol import smooth_step

Array = NDArray[np.float64]
Progress = Callable[[float], None]

LANCZOS_STEPS = 16
"""Enough for the largest eigenvalue within some percent, which the safety factor covers."""


@dataclass(frozen=True)
class SolverSettings:
    """Numerical choices; mirrors the config section `solver:`.

    Parameters
    ----------
    precision : str
        `float32` or `float64` for displacements, velocities and element data.
    loading_time_s : float
        Duration of the smooth-step loading [s] for a shear modulus of `reference_modulus_pa` and
        a density of `density_kg_m3`. Only the ratio to the shear wave's transit time matters.
    reference_modulus_pa : float
        Shear modulus of the unit-modulus runs [Pa].
    density_kg_m3 : float
        Mass density [kg/m3]; inertia is a tool here, not physics.
    safety_factor : float
        Fraction of the critical time step that is used, in (0, 1).
    step_updates : int
        How often the critical step is estimated again while the mesh deforms.
    hourglass_coefficient : float
        Hourglass stiffness in units of ``mu V (B:B) / 64``.
    curve_points : int
        Evenly spaced displacements of the output curve, zero not counted.
    """

    precision: str = "float32"
    loading_time_s: float = 0.13
    reference_modulus_pa: float = 1000.0
    density_kg_m3: float = 1000.0
    safety_factor: float = 0.85
    step_updates: int = 20
    hourglass_coefficient: float = 0.5
    curve_points: int = 60

    @property
    def dtype(self) -> np.dtype:
        """NumPy type of the state."""
        return np.dtype(self.precision)


@dataclass(frozen=True)
class Run:
    """Result of one explicit run.

    Parameters
    ----------
    displacement : (n_points,) float64
        Travel of the moving platen along its direction [m], evenly spaced from zero.
    force, platen_force, base_force : (n_points,) float64
        Component of the force on the sample along the direction of travel [N]: quasi-static
        estimate ``(platen - 2 base) / 3``, by the moving platen, by the base.
    displacement_field : (n_nodes, 3) float64
        Nodal displacements at the end [m].
    held : (n_nodes,) int8
        What holds each node at the end (FREE, BASE, PLATEN).
    energy : dict of float
        At the end [J]: `strain`, `hourglass`, `kinetic`, `work`, and the largest `imbalance`
        and `hourglass_ratio` along the way, relative to the final strain energy.
    steps : int
        Number of time steps.
    smallest_step_s : float
        Smallest time step [s].
    """

    displacement: Array
    force: Array
    platen_force: Array
    base_force: Array
    displacement_field: Array
    held: NDArray[np.int8]
    energy: dict[str, float]
    steps: int
    smallest_step_s: float


@dataclass
class _State:
    """Everything that moves; `history` grows by one row per time step."""

    u: NDArray
    v: NDArray
    force: NDArray
    element: NDArray
    held: NDArray[np.int8]
    mobility: NDArray
    history: list[Array] = field(default_factory=list)
    energies: list[Array] = field(default_factory=list)
    work: float = 0.0
    dt: float = 0.0
    smallest_dt: float = np.inf


class ExplicitModel:
    """A mesh packed into element blocks, ready to be loaded with any material and test.

    Parameters
    ----------
    mesh : HexMesh
        Reference configuration [m].
    settings : SolverSettings
        Numerical choices.

    Raises
    ------
    MeshError
        If an element has no positive volume.

    Notes
    -----
    One-point hexahedra with mean gradients and stiffness hourglass control, central differences,
    lumped mass; the theory is in ``docs/solver.md``.

    References
    ----------
    D. P. Flanagan, T. Belytschko, Int. J. Numer. Meth. Engng 17 (1981) 679,
    doi:10.1002/nme.1620170504.
    """

    def __init__(self, mesh: HexMesh, settings: SolverSettings) -> None:
        self.mesh = mesh
        self.settings = settings
        geometry = hex_geometry(mesh)
        self.mass = lumped_mass(mesh, geometry, settings.density_kg_m3)
        n = len(mesh.hexes)
        lanes = kernels.LANES
        blocks = np.minimum(np.arange(-(-n // lanes) * lanes), n - 1).reshape(-1, lanes)

        def pack(values: NDArray, dtype: np.dtype) -> NDArray:
            return np.ascontiguousarray(np.moveaxis(values[blocks], 1, -1), dtype=dtype)

        dtype = settings.dtype
        self._connectivity = pack(mesh.hexes, np.dtype(np.int32))
        self._gradient = pack(geometry.gradient, dtype)
        self._hourglass = pack(geometry.hourglass, dtype)
        self._volume = pack(geometry.volume, dtype)
        squared = np.einsum("nai,nai->n", geometry.gradient, geometry.gradient)
        self._unit_stiffness = pack(geometry.volume * squared / 64.0, dtype)

    def elements(self, shear_modulus: float) -> tuple:
        """Kernel argument `elements` for a material of `shear_modulus` [Pa]."""
        scale = self.settings.dtype.type(self.settings.hourglass_coefficient * shear_modulus)
        return (
            self._connectivity,
            self._gradient,
            self._hourglass,
            self._volume,
            self._unit_stiffness * scale,
            len(self.mesh.hexes),
        )

    def internal_force(
        self, displacement: Array, material: OgdenMaterial, spectral: bool | None = None
    ) -> tuple[Array, Array]:
        """Internal forces (n_nodes, 3) [N] and element state of given displacements [m].

        The element state (3, n_elements) holds strain energy [J], hourglass energy [J] and J - 1.
        `spectral` forces the path by eigenvalues (default: only for exponents that need it).
        """
        u = np.ascontiguousarray(displacement, dtype=self.settings.dtype)
        force = np.empty_like(u)
        state = np.empty((3, *self._volume.shape), dtype=u.dtype)
        elements = self.elements(material.shear_modulus)
        kernels.internal_force(u, elements, _kernel_material(material, spectral), force, state)
        flat = state.reshape(3, -1)[:, : len(self.mesh.hexes)]
        return force.astype(np.float64), flat.astype(np.float64)

    def run(
        self,
        material: OgdenMaterial,
        boundary: Boundary,
        travel: float,
        *,
        slowdown: float = 1.0,
        spectral: bool | None = None,
        progress: Progress | None = None,
    ) -> Run:
        """Load the sample by `travel` [m] of the moving platen and record the forces.

        Parameters
        ----------
        material : OgdenMaterial
            Its shear modulus scales the loading time with the wave speed, so that curves of
            ``k mu`` are ``k`` times those of ``mu``.
        boundary : Boundary
            What holds and moves the sample.
        travel : float
            Travel along the boundary's direction [m], > 0.
        slowdown : float
            Factor on the loading time (two for the error bound).
        spectral : bool, optional
            Force the path by eigenvalues.
        progress : callable, optional
            Told the finished fraction now and then.

        Raises
        ------
        SimulationError
            When an element inverts or the solution stops being finite.
        """
        if not travel > 0.0:
            raise SimulationError(f"the platen must travel, got {travel:g} m; check the record")
        loading = _Loading(self, material, boundary, travel, slowdown, spectral)
        with flushed_denormals():
            loading.march(progress)
        return loading.result()


def _kernel_material(material: OgdenMaterial, spectral: bool | None) -> tuple:
    path = (not material.even) if spectral is None else spectral
    if not path and not material.even:
        raise SimulationError(
            f"exponents {material.alpha} are not all even integers: use the spectral path"
        )
    return np.array(material.mu), np.array(material.alpha, float), material.bulk_modulus, path


class _Loading:
    """One run in progress."""

    def __init__(
        self,
        model: ExplicitModel,
        material: OgdenMaterial,
        boundary: Boundary,
        travel: float,
        slowdown: float,
        spectral: bool | None,
    ) -> None:
        settings = model.settings
        self.model, self.boundary, self.travel = model, boundary, travel
        self.elements = model.elements(material.shear_modulus)
        self.material = _kernel_material(material, spectral)
        speed_up = np.sqrt(settings.reference_modulus_pa / material.shear_modulus)
        self.duration = settings.loading_time_s * slowdown * float(speed_up)
        shape, dtype = model.mesh.points.shape, settings.dtype
        self.rng = np.random.default_rng(0)
        self.critical = 0.0
        self.state = _State(
            u=np.zeros(shape, dtype),
            v=np.zeros(shape, dtype),
            force=np.zeros(shape, dtype),
            element=np.zeros((3, *model._volume.shape), dtype),
            held=boundary.held.copy(),
            mobility=np.where(boundary.held == kernels.FREE, 1.0 / model.mass, 0.0)[:, None]
            .repeat(3, axis=1)
            .astype(dtype),
        )

    def march(self, progress: Progress | None) -> None:
        """Go through the loading in slices of constant step, then record the final state."""
        slices = self.model.settings.step_updates
        for k in range(slices):
            allowed = self.model.settings.safety_factor * self._critical_step()
            n = int(np.ceil(self.duration / slices / allowed))
            times = (k + np.arange(n + 1) / n) / slices
            self._advance(self.travel * smooth_step(times), self.duration / slices / n)
            self._check((k + 1) / slices)
            if progress is not None:
                progress((k + 1) / slices)
        self._advance(np.full(2, self.travel), self.state.dt)

    def _advance(self, path: Array, dt: float) -> None:
        s, b, model = self.state, self.boundary, self.model
        history = np.empty((len(path) - 1, 7))
        kernels.advance(
            path, dt, s.dt or dt, s.u, s.v, s.force, s.element, self.elements, self.material,
            model.mass, s.mobility, model.mesh.points, s.held, (b.glued, b.candidates), b.planes,
            b.direction, b.release, history,
        )  # fmt: skip
        s.dt, s.smallest_dt = dt, min(s.smallest_dt, dt)
        # trapezoidal rule up to the last forces, the instant of the strain energy below
        rows = np.concatenate([s.history[-1][-1:], history]) if s.history else history
        s.work += float(np.trapezoid(rows[:, 1:4] @ b.direction, rows[:, 0]))
        s.history.append(history)
        kinetic = 0.5 * float(model.mass @ np.einsum("ni,ni->n", s.v, s.v, dtype=np.float64))
        flat = s.element.reshape(3, -1)[:, : self.elements[5]]
        s.energies.append(np.array([*flat[:2].sum(axis=1, dtype=np.float64), kinetic, s.work]))

    def _critical_step(self) -> float:
        """``2 / omega_max`` of the current tangent, extrapolated to the end of the next slice."""
        critical = 2.0 / np.sqrt(self._largest_eigenvalue())
        before, self.critical = self.critical, critical
        return critical * min(1.0, critical / (before or critical))

    def _largest_eigenvalue(self) -> float:
        """Largest eigenvalue of ``M^-1 K`` [1/s2] by Lanczos on differences of forces.

        A fresh random start lets the estimate find a local mode that has just become the stiffest;
        the residual is added, so that the value errs on the safe side.
        """
        s, steps = self.state, LANCZOS_STEPS
        mass = np.where(s.held == kernels.FREE, self.model.mass, 0.0)[:, None].astype(s.u.dtype)
        kernels.internal_force(s.u, self.elements, self.material, s.force, s.element)
        reach = 1e-3 * self.model.mesh.edge_length
        q = self.rng.standard_normal(s.u.shape, dtype=s.u.dtype) * (mass > 0.0)
        q /= np.sqrt(np.vdot(q, q * mass))
        before, beta = np.zeros_like(q), 0.0
        force = np.empty_like(q)
        diagonal, off = np.empty(steps), np.empty(steps)
        for k in range(steps):
            scale = q.dtype.type(reach / np.abs(q).max())
            kernels.internal_force(s.u + scale * q, self.elements, self.material, force, s.element)
            w = (force - s.force) / scale * s.mobility
            diagonal[k] = np.vdot(w, q * mass)
            w -= diagonal[k] * q + beta * before
            beta = off[k] = np.sqrt(np.vdot(w, w * mass))
            before, q = q, w / beta
        values, vectors = eigh_tridiagonal(diagonal, off[:-1])
        bound = float(values[-1] + abs(off[-1] * vectors[-1, -1]))
        if not (np.isfinite(bound) and values[-1] > 0.0):
            raise SimulationError(
                "the stiffness of the mesh is not positive; check the mesh quality report "
                "and lower solver: safety_factor"
            )
        return bound

    def _check(self, fraction: float) -> None:
        """Refuse inverted elements and numbers that are not finite."""
        dilatation = self.state.element.reshape(3, -1)[2, : self.elements[5]]
        worst = int(np.argmin(np.nan_to_num(dilatation, nan=-np.inf)))
        if not dilatation[worst] > -0.9:
            centre = 1e3 * self.model.mesh.points[self.model.mesh.hexes[worst]].mean(axis=0)
            raise SimulationError(
                f"element {worst} near {np.round(centre, 2).tolist()} mm has J = "
                f"{1.0 + float(dilatation[worst]):.3g} at {100 * fraction:.0f} % of the loading "
                f"time; lower solver: safety_factor, raise solver: hourglass_coefficient, "
                "or end the record at a smaller strain"
            )

    def result(self) -> Run:
        """Interpolate the history at even displacements and sum the energies up."""
        s, direction = self.state, self.boundary.direction
        history = np.concatenate(s.history)
        displacement = np.linspace(0.0, self.travel, self.model.settings.curve_points + 1)
        platen, base = (
            np.interp(displacement, history[:, 0], history[:, k : k + 3] @ direction)
            for k in (1, 4)
        )
        energies = np.array(s.energies)
        strain, hourglass, kinetic, work = energies.T
        imbalance = np.abs(strain + hourglass + kinetic - work).max() / strain[-1]
        loaded = strain > 0.01 * strain[-1]
        return Run(
            displacement=displacement,
            force=(platen - 2.0 * base) / 3.0,
            platen_force=platen,
            base_force=base,
            displacement_field=s.u.astype(np.float64),
            held=s.held,
            energy={
                "strain": strain[-1],
                "hourglass": hourglass[-1],
                "kinetic": kinetic[-1],
                "work": work[-1],
                "imbalance": float(imbalance),
                "hourglass_ratio": float((hourglass[loaded] / strain[loaded]).max()),
            },
            steps=len(history),
            smallest_step_s=s.smallest_dt,
        )
