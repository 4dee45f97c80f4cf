"""Explicit total-Lagrangian dynamics of one test: public face of the solver."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Array, Mask
from softsample.constitutive.law import FibreLaw, InvariantLaw, SpectralLaw
from softsample.constitutive.laws import LAWS
from softsample.constitutive.material import Material, Term
from softsample.errors import CrushedError, InputError, SimulationError
from softsample.fem.blocks import aligned, groups_first, is_grouped, pack
from softsample.fem.boundary import Boundary
from softsample.fem.denormals import flushed_denormals
from softsample.fem.element import hex_geometry, lumped_mass
from softsample.fem.fields import Snapshot
from softsample.fem.forces import Elements, internal_force
from softsample.fem.lanes import LANES
from softsample.fem.motion import FREE, PLATEN, Motion, advance
from softsample.fem.schedule import Schedule
from softsample.fem.stability import largest_eigenvalue
from softsample.fem.stress import NUMBERS, Solid
from softsample.meshing.mesh import HexMesh
from softsample.protocol import History

Progress = Callable[[float], None]

JACOBI_SWEEPS = {"float32": 3, "float64": 4}
"""Sweeps that bring a 3x3 matrix to diagonal form within rounding; they converge quadratically."""

BACKENDS = {"vector": None, "scalar": 0}
"""Kernel argument `lane` of each backend."""

LEAST_STEP = 1e-3
"""Part of the first stable time step below which elements are crushed, and a run would not end."""

STEP_UPDATES = 12
"""How often per loading the critical time step is estimated again: each takes a dozen evaluations
of the force, and between them the step is extrapolated where it falls."""


@dataclass(frozen=True)
class SolverSettings:
    """Numerical choices; mirrors the config section `solver:`.

    Parameters
    ----------
    backend : str
        `vector` for explicit vector code, `scalar` for the same kernels one element at a time.
    precision : str
        `float32` or `float64` for displacements, velocities and element data.
    loading_time_s : float
        Duration of the smooth-step loading over the whole reach [s] for a shear modulus of
        `reference_modulus_pa` and a density of `density_kg_m3`; only the ratio to the shear
        wave's transit time matters. The search for that of response curves starts here.
    curve_error_percent : float
        Error of the finite loading time that response curves may have [% of peak force].
    reference_modulus_pa : float
        Shear modulus of the unit-modulus runs [Pa].
    density_kg_m3 : float
        Mass density [kg/m3]; inertia is a tool here, not physics.
    safety_factor : float
        Fraction of the critical time step that is used, in (0, 1).
    hourglass_coefficient : float
        Hourglass stiffness in units of ``mu V (B:B) / 64``.
    curve_points : int
        Evenly spaced points of the output curve in each leg of the history, its start not counted.
    """

    backend: str = "vector"
    precision: str = "float32"
    loading_time_s: float = 0.12
    curve_error_percent: float = 0.5
    reference_modulus_pa: float = 1000.0
    density_kg_m3: float = 1000.0
    safety_factor: float = 0.85
    hourglass_coefficient: float = 0.5
    curve_points: int = 60

    @property
    def dtype(self) -> np.dtype:
        """NumPy type of the state."""
        return np.dtype(self.precision)


@dataclass(frozen=True)
class Gravity:
    """The sample's own weight.

    Parameters
    ----------
    density_kg_m3 : float
        Mass density of the tissue [kg/m3].
    acceleration : (3,) tuple of float
        In the sample frame [m/s2].
    settle_first : bool
        Whether the sample settles freely on the base before the platen is glued to it or brought
        to its highest point. If not, what holds it at the start does so from the beginning.
    """

    density_kg_m3: float = 1040.0
    acceleration: tuple[float, float, float] = (0.0, 0.0, -9.81)
    settle_first: bool = True


@dataclass(frozen=True)
class Run:
    """Result of one explicit run.

    Parameters
    ----------
    time, displacement : (n_points,) float64
        Time of the test [s] and travel of the moving platen along its direction [m], evenly
        spaced in each leg of the history.
    force, platen_force, base_force : (n_points,) float64
        Component of the force on the sample along the direction of travel [N]: quasi-static
        estimate ``(platen - 2 base) / 3`` (of an indenter, its own force), by the moving platen,
        by the base. Own weight is borne by both; its part at zero travel is what a taring
        afterwards takes off.
    force_vector : (n_points, 3) float64
        The quasi-static estimate in the sample frame [N]. Forces of the walls of a confined test
        are not in it.
    displacement_field : (n_nodes, 3) float64
        Nodal displacements at the end [m].
    held : (n_nodes,) int8
        What holds each node at the end (FREE, BASE, PLATEN).
    energy : dict of float
        At the end [J]: `strain`, `hourglass`, `kinetic`, `work`, and the largest `imbalance`
        and `hourglass_ratio` along the way, relative to the largest strain energy. With
        relaxation `strain` is that of an elastic solid and `imbalance` means nothing (nan).
    energies : dict of (n_slices,) float64
        `displacement` [m], `strain`, `hourglass`, `kinetic`, `work` [J] along the way.
    snapshots : tuple of Snapshot
        In the order of time.
    steps : int
        Number of time steps.
    smallest_step_s : float
        Smallest time step [s].
    """

    time: Array
    displacement: Array
    force: Array
    platen_force: Array
    base_force: Array
    force_vector: Array
    displacement_field: Array
    held: NDArray[np.int8]
    energy: dict[str, float]
    energies: dict[str, Array]
    snapshots: tuple[Snapshot, ...]
    steps: int
    smallest_step_s: float


class ExplicitModel:
    """A mesh packed into element blocks, ready to be loaded with any material and test.

    Parameters
    ----------
    mesh : HexMesh
        Reference configuration [m].
    settings : SolverSettings
        Numerical choices.
    relative_stiffness : (n_elements,) float64, optional
        Factors on all moduli, element by element, for regions of different stiffness.

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

    def __init__(
        self, mesh: HexMesh, settings: SolverSettings, relative_stiffness: Array | None = None
    ) -> None:
        self.mesh = mesh
        self.settings = settings
        geometry = hex_geometry(mesh)
        self.mass = lumped_mass(mesh, geometry, settings.density_kg_m3)
        factor = np.ones(len(mesh.hexes)) if relative_stiffness is None else relative_stiffness
        squared = np.einsum("nai,nai->n", geometry.gradient, geometry.gradient)
        weight = factor * geometry.volume
        dtype = settings.dtype
        regular = np.flatnonzero(geometry.is_parallelepiped)
        regular = regular[: len(regular) // LANES[dtype] * LANES[dtype]]
        rest = np.setdiff1d(np.arange(len(mesh.hexes)), regular)
        regular, rest = (groups_first(part, mesh.hexes, dtype) for part in (regular, rest))
        self._order = np.concatenate([regular, rest])
        nodes = pack(mesh.hexes[self._order], dtype)
        self._unit_elements = Elements(
            nodes,
            is_grouped(nodes),
            pack(geometry.slopes[regular], dtype),
            pack(geometry.gradient[rest], dtype),
            pack(geometry.hourglass[rest], dtype),
            pack(weight[self._order], dtype, padding=0.0),
            pack((weight * squared / 64.0)[self._order], dtype, padding=0.0),
        )

    def elements(self, shear_modulus: float) -> Elements:
        """Kernel argument `elements` for a material of `shear_modulus` [Pa]."""
        scale = self.settings.dtype.type(self.settings.hourglass_coefficient * shear_modulus)
        stiffness = aligned(self._unit_elements.stiffness.shape, self.settings.dtype)
        stiffness[:] = self._unit_elements.stiffness * scale
        return self._unit_elements._replace(stiffness=stiffness)

    def flat(self, state: NDArray) -> NDArray:
        """Element values (..., n_elements) of blocks (..., n_blocks, n), in the mesh's order."""
        values = np.empty((*state.shape[:-2], len(self._order)), state.dtype)
        values[..., self._order] = state.reshape(*state.shape[:-2], -1)[..., : len(self._order)]
        return values

    def internal_force(self, displacement: Array, material: Material) -> tuple[Array, Array]:
        """Internal forces (n_nodes, 3) [N] and element state of given displacements [m].

        The element state (3, n_elements) holds strain energy [J], hourglass energy [J] and J - 1.
        Relaxation has no part in it.
        """
        u = self.nodal(displacement)
        force, state = np.empty_like(u), self.blank_state()
        self.add_up(u, self.elements(material.shear_modulus), self.solid(material), force, state)
        return force[:, :3].astype(np.float64), self.flat(state).astype(np.float64)

    def add_up(
        self,
        u: NDArray,
        elements: Elements,
        solid: Solid,
        force: NDArray,
        state: NDArray,
    ) -> None:
        """Internal force of a solid, its relaxation left out."""
        solid = solid._replace(prony=np.empty(0))
        none = np.empty((2, 0)), np.empty((0, 1, 6, state.shape[-1]), u.dtype)
        lane = BACKENDS[self.settings.backend]
        internal_force(u, elements, solid, *none, force, state, True, lane)

    def nodal(self, values: Array | None = None) -> NDArray:
        """Rows of four for the kernels, zero or filled with values (n_nodes, 3)."""
        rows = aligned((len(self.mesh.points), 4), self.settings.dtype)
        if values is not None:
            rows[:, :3] = values
        return rows

    def blank_state(self) -> NDArray:
        """Zeros for the state of the elements."""
        return aligned((3, *self._unit_elements.volume.shape), self.settings.dtype)

    def solid(self, material: Material) -> Solid:
        """Kernel argument `solid`."""
        by_shape = sorted(material.terms, key=lambda term: [abs(x) for x in term.shape])
        kinds = SpectralLaw, InvariantLaw, FibreLaw
        groups = [[t for t in by_shape if isinstance(t.rule, kind)] for kind in kinds]
        terms = [term for group in groups for term in group]
        shape = np.zeros((len(terms), max(len(law.shape) for law in LAWS.values())))
        for row, term in zip(shape, terms, strict=True):
            row[: len(term.shape)] = term.shape
        relaxation = material.relaxation
        return Solid(
            np.array([term.modulus for term in terms]),
            np.array([NUMBERS[term.law] for term in terms]),
            shape,
            np.array([term.direction for term in terms], float),
            len(groups[0]),
            len(groups[0]) + len(groups[1]),
            material.volumetric_modulus,
            self._sweeps(groups[0]),
            np.array(relaxation.g if relaxation else (), float),
        )

    def _sweeps(self, terms: Sequence[Term]) -> int:
        """Jacobi sweeps for the terms in principal stretches; none where products do."""
        products = all(term.rule.even_power(term.shape) for term in terms)
        return 0 if products else JACOBI_SWEEPS[self.settings.precision]

    def run(
        self,
        material: Material,
        boundary: Boundary,
        loading: float | History,
        *,
        loading_time: float | None = None,
        gravity: Gravity | None = None,
        start: Array | None = None,
        snapshots: Sequence[float] = (),
        progress: Progress | None = None,
    ) -> Run:
        """Move the platen and record the forces.

        Parameters
        ----------
        material : Material
            Its shear modulus scales the loading time with the wave speed, so that curves of
            ``k mu`` are ``k`` times those of ``mu`` (without gravity).
        boundary : Boundary
            What holds and moves the sample.
        loading : float or History
            Travel of a single ramp along the boundary's direction [m], or any history.
        loading_time : float, optional
            Solver time of a ramp over the whole reach for the reference modulus [s]; default is
            that of the settings.
        gravity : Gravity, optional
            The sample's own weight.
        start : (n_nodes, 3) float64, optional
            Displacements [m] to start from, at rest: where an earlier run ended. The platens'
            planes are where `boundary` has them.
        snapshots : sequence of float
            Times of the test [s] at which to keep the deformed shape, ascending from above 0; a
            single ramp lasts 1 s.
        progress : callable, optional
            Told the finished fraction now and then.

        Raises
        ------
        InputError
            If the platen does not travel, or the times of snapshots are none of the test's.
        SimulationError
            When an element inverts, the solution stops being finite or nothing is strained.
        """
        history = loading if isinstance(loading, History) else History.ramp(loading)
        times, end = np.array([0.0, *snapshots]), history.time[-1]
        if np.any(np.diff(times) <= 0.0) or times[-1] > (1.0 + 1e-9) * end:
            raise InputError(f"snapshots at {times[1:]} s do not ascend from above 0 to {end:g} s")
        pace = np.sqrt(self.settings.reference_modulus_pa / material.shear_modulus)
        duration = float(pace) * (loading_time or self.settings.loading_time_s)
        schedule = Schedule(history, duration, duration if gravity else 0.0)
        march = _March(self, material, boundary, schedule, gravity)
        if start is not None:
            march.motion.u[:, :3] = start
            march.records.work = self.internal_force(start, material)[1][:2].sum()
        with flushed_denormals():
            march.go(times[1:], progress)
        return march.result()


@dataclass
class _Records:
    """What a march has noted: rows per time step, rows per slice."""

    clock: list[Array] = field(default_factory=list)
    forces: list[Array] = field(default_factory=list)
    weight: list[Array] = field(default_factory=list)
    energies: list[Array] = field(default_factory=list)
    snapshots: list[Snapshot] = field(default_factory=list)
    work: float = 0.0
    smallest_dt: float = np.inf


class _March:
    """One run in progress."""

    def __init__(
        self,
        model: ExplicitModel,
        material: Material,
        boundary: Boundary,
        schedule: Schedule,
        gravity: Gravity | None,
    ) -> None:
        self.model, self.boundary, self.schedule = model, boundary, schedule
        self.relaxation, self.gravity = material.relaxation, gravity
        self.elements = model.elements(material.shear_modulus)
        volume = model.mass.sum() / model.settings.density_kg_m3
        # of the strain energy of elements at rest, in single precision
        self.rounding = float(np.finfo(model.settings.dtype).eps * material.shear_modulus * volume)
        self.solid = model.solid(material)
        self.platens = boundary.platens()
        self.dt = self.clock = self.critical = self.first_step = 0.0
        self.rng = np.random.default_rng(0)
        self.records = _Records()
        state, terms = model.blank_state(), self.solid.prony.size
        blocks, count = state.shape[1:] if terms else (0, state.shape[2])
        rows = -(-4 * len(model.mass) // count)
        u, v, force, mobility = (aligned((rows, count), model.settings.dtype) for _ in range(4))
        nodes = slice(len(model.mass))
        self.motion = Motion(
            u.reshape(-1, 4)[nodes], v.reshape(-1, 4)[nodes], force.reshape(-1, 4)[nodes],
            mobility.reshape(-1, 4)[nodes], boundary.held.copy(), model.mass,
            model.mesh.points, state, aligned((blocks, terms + 1, 6, count), model.settings.dtype),
            (u, v, force, mobility),
        )  # fmt: skip
        if gravity and gravity.settle_first:
            self._lift_platen()
        self._free()

    def _lift_platen(self) -> None:
        """Take the moving platen off while the sample settles."""
        self.motion.held[self.motion.held == PLATEN] = FREE
        planes = self.platens.planes.copy()
        planes[1, 3] = np.inf
        base = self.platens.glued[0]
        self.platens = self.platens._replace(planes=planes, glued=(base, base[:0]))

    def _lower_platen(self) -> None:
        """Glue the platen to the settled sample, or bring it down with the highest point."""
        self.platens = self.boundary.platens()
        glued = self.boundary.held == PLATEN
        self.motion.held[glued] = PLATEN
        if np.isfinite(self.platens.planes[1, 3]):
            ids = self.platens.candidates
            planes = self.platens.planes.copy()
            rest = self.model.mesh.points[ids]
            heights = [
                (place @ planes[1, :3]).max() for place in (rest, rest + self.motion.u[ids, :3])
            ]
            planes[1, 3] += heights[1] - heights[0]
            self.platens = self.platens._replace(planes=planes)
        self._free()

    def _free(self) -> None:
        """Inverse masses of the nodes that nothing holds, along the axes that no wall blocks."""
        free = self.motion.held == FREE
        mobility = np.where(free, 1.0 / self.model.mass, 0.0)
        self.motion.mobility[:, :3] = mobility[:, None] * self.platens.mobile

    def go(self, snapshots: Array, progress: Progress | None) -> None:
        """March through the schedule in slices of constant step, then record the final state."""
        stops = self.schedule.solver_time(snapshots)
        ends = self.schedule.slices(STEP_UPDATES, stops)
        lifted = self.gravity is not None and self.gravity.settle_first
        for start, end in pairwise(ends):
            if lifted and abs(start - self.schedule.settling) < self.schedule.tick:
                self._lower_platen()
            allowed = self._allowed_step(end / ends[-1])
            n = int(np.ceil((end - start) / allowed))
            self._advance(np.linspace(start, end, n + 1), (end - start) / n)
            self._check(end / ends[-1])
            if np.any(np.abs(stops - end) < 0.6 * self.schedule.tick):
                self._take_snapshot(end)
            if progress is not None:
                progress(end / ends[-1])
        self._advance(np.full(2, ends[-1]), self.dt)

    def _advance(self, times: Array, dt: float) -> None:
        clock = self.schedule.clock(times)
        share = self.schedule.gravity(times[:-1])[:, None] * self._body_acceleration()
        history = np.empty((len(times) - 1, 7))
        ticks = np.diff(clock[:-1], prepend=self.clock)
        advance(
            self.schedule.travel(clock), share, self._relax(ticks), dt, self.dt or dt, self.motion,
            self.elements, self.solid, self.platens, history,
            BACKENDS[self.model.settings.backend],
        )  # fmt: skip
        self.dt, self.clock = dt, clock[-2]
        self._note(clock[:-1], history, share)

    def _body_acceleration(self) -> Array:
        """Acceleration [m/s2] that gives the tissue's weight to the solver's masses."""
        if self.gravity is None:
            return np.zeros(3)
        ratio = self.gravity.density_kg_m3 / self.model.settings.density_kg_m3
        return ratio * np.asarray(self.gravity.acceleration)

    def _relax(self, ticks: Array) -> Array:
        """Decay and gain of every Prony term in steps of the test's clock [s]."""
        if self.relaxation is None:
            return np.empty((len(ticks), 2, 0))
        x = ticks[:, None] / np.array(self.relaxation.tau_s)
        gain = np.divide(-np.expm1(-x), x, out=np.ones_like(x), where=x > 0.0)
        return np.stack([np.exp(-x), np.array(self.relaxation.g) * gain], axis=1)

    def _note(self, clock: Array, history: Array, share: Array) -> None:
        """Append to the records; work is that of platen and body force."""
        r, motion, mass = self.records, self.motion, self.model.mass
        direction = self.boundary.direction
        force, travel = history[:, :3] @ direction, self.schedule.travel(clock)
        if r.forces:  # trapezoidal rule up to the last forces, the instant of the strain energy
            force = np.concatenate([r.forces[-1][-1:, :3] @ direction, force])
            travel = np.concatenate([self.schedule.travel(r.clock[-1][-1:]), travel])
        r.work += float(np.trapezoid(force, travel)) + float(history[:, 6].sum())
        r.clock.append(clock)
        r.forces.append(history[:, :6])
        r.weight.append(share * mass.sum())
        r.smallest_dt = min(r.smallest_dt, self.dt)
        v = motion.v[:, :3]
        kinetic = 0.5 * float(mass @ np.einsum("ni,ni->n", v, v, dtype=np.float64))
        strain, hourglass = self.model.flat(motion.state)[:2].sum(axis=1, dtype=np.float64)
        r.energies.append(np.array([travel[-1], strain, hourglass, kinetic, r.work]))

    def _take_snapshot(self, time: float) -> None:
        motion, clock = self.motion, self.schedule.clock(np.array(time))
        touched = (motion.held == PLATEN)[:, None]
        self.records.snapshots.append(
            Snapshot(
                float(self.schedule.travel(clock)),
                motion.u[:, :3].astype(np.float64),
                motion.held.copy(),
                np.where(touched, motion.force[:, :3], 0.0).astype(np.float64),
            )
        )

    def _allowed_step(self, fraction: float) -> float:
        """A stable step for the next slice; one that has shrunk to nothing is refused."""
        allowed = self.model.settings.safety_factor * self._critical_step()
        self.first_step = self.first_step or allowed
        if allowed < LEAST_STEP * self.first_step:
            raise CrushedError(
                f"the stable time step has shrunk to {allowed:.2g} s at {100 * fraction:.0f} % of "
                "the loading time, as elements are crushed; raise solver: loading_time_s, or end "
                "the record at a smaller strain"
            )
        return allowed

    def _critical_step(self) -> float:
        """``2 / omega_max`` of the current tangent, extrapolated to the end of the next slice."""
        model, motion = self.model, self.motion
        rest, bent = model.nodal(), model.nodal()
        state = model.blank_state()
        model.add_up(motion.u, self.elements, self.solid, rest, state)
        reach = 1e-3 * model.mesh.edge_length

        def stiffness(q: NDArray) -> NDArray:
            scale = q.dtype.type(reach / np.abs(q).max())
            model.add_up(motion.u + scale * q, self.elements, self.solid, bent, state)
            return (bent - rest) / scale

        mass = np.where(self._movable(), model.mass, 0.0)
        start = model.nodal(self.rng.standard_normal((len(mass), 3)))
        value = largest_eigenvalue(stiffness, mass[:, None].astype(start.dtype), start)
        before, self.critical = self.critical, 2.0 / float(np.sqrt(value))
        return self.critical * min(1.0, self.critical / (before or self.critical))

    def _movable(self) -> Mask:
        """Nodes that are free, or may slide on a platen."""
        sliding = np.zeros(len(self.motion.held), bool)
        if np.isfinite(self.platens.friction).any():
            sliding[self.platens.candidates] = True
        return sliding | (self.motion.held == FREE)

    def _check(self, fraction: float) -> None:
        """Refuse inverted elements and numbers that are not finite."""
        dilatation = self.model.flat(self.motion.state)[2]
        worst = int(np.argmin(np.nan_to_num(dilatation, nan=-np.inf)))
        if not dilatation[worst] > -0.9:
            mesh = self.model.mesh
            centre = 1e3 * mesh.points[mesh.hexes[worst]].mean(axis=0)
            travel = 1e3 * float(self.schedule.travel(self.clock))
            raise CrushedError(
                f"element {worst} near {np.round(centre, 2).tolist()} mm has J = "
                f"{1.0 + float(dilatation[worst]):.3g} at {100 * fraction:.0f} % of the loading "
                f"time ({travel:.2f} mm of displacement); lower solver: safety_factor, raise "
                "solver: loading_time_s or hourglass_coefficient, or end the record at a smaller "
                "strain"
            )

    def result(self) -> Run:
        """Interpolate the records at even times and sum the energies up."""
        r, direction = self.records, self.boundary.direction
        clock, first = np.concatenate(r.clock), 0
        if self.schedule.settling:
            first = int(np.searchsorted(clock, 0.0, side="right")) - 1
        time = self.schedule.times(self.model.settings.curve_points)

        def sampled(rows: list[Array]) -> Array:
            columns = np.concatenate(rows)[first:].T
            return np.stack([np.interp(time, clock[first:], column) for column in columns], axis=1)

        forces, weight = sampled(r.forces), sampled(r.weight)
        platen, base = forces[:, :3], forces[:, 3:]
        # of a large sample around a small indenter, inertia is in the force on its base
        force = platen if self.boundary.local else (platen - 2.0 * (base + weight)) / 3.0
        energy, energies = self._energies()
        return Run(
            time=time,
            displacement=self.schedule.travel(time),
            force=force @ direction,
            platen_force=platen @ direction,
            base_force=base @ direction,
            force_vector=force,
            displacement_field=self.motion.u[:, :3].astype(np.float64),
            held=self.motion.held,
            energy=energy,
            energies=energies,
            snapshots=tuple(r.snapshots),
            steps=len(clock),
            smallest_step_s=r.smallest_dt,
        )

    def _energies(self) -> tuple[dict[str, float], dict[str, Array]]:
        columns = ("displacement", "strain", "hourglass", "kinetic", "work")
        along = dict(zip(columns, np.array(self.records.energies).T, strict=True))
        strain, hourglass = along["strain"], along["hourglass"]
        if not strain.any():
            raise SimulationError(
                f"nothing was strained in {1e3 * along['displacement'][-1]:.3g} mm of "
                "displacement: the platen does not reach the sample; choose a smaller gap, or a "
                "longer record"
            )
        missing = np.abs(strain + hourglass + along["kinetic"] - along["work"]).max()
        imbalance = max(missing - self.rounding, 0.0)
        loaded = strain > 0.01 * strain.max()
        return {
            **{name: float(along[name][-1]) for name in columns[1:]},
            "imbalance": np.nan if self.relaxation else float(imbalance / strain.max()),
            "hourglass_ratio": float((hourglass[loaded] / strain[loaded]).max()),
        }, along
