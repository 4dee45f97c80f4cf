"""Time integration and platens of the explicit solver, compiled.

Arguments are checked by `softsample.fem.explicit`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from softsample.fem.forces import add_forces
from softsample.fem.lanes import compiled, inline, like, load, store
from softsample.fem.tensors import dot

FREE, BASE, PLATEN = 0, 1, 2
"""What holds a node: nothing, the fixed base platen, the moving platen."""


class Motion(NamedTuple):
    """State of the nodes and elements."""

    u: NDArray
    """(n_nodes, 4) displacements [m]; the fourth column is not used."""
    v: NDArray
    """(n_nodes, 4) velocities [m/s], half a step behind."""
    force: NDArray
    """(n_nodes, 4) internal less body force [N] of the last step."""
    mobility: NDArray
    """(n_nodes, 4) inverse mass of free nodes [1/kg], zero for held ones; dtype of `u`."""
    held: NDArray
    """(n_nodes,) int8: FREE, BASE or PLATEN; contact changes it."""
    mass: NDArray
    """(n_nodes,) float64 lumped masses [kg]."""
    points: NDArray
    """(n_nodes, 3) float64 reference positions [m]."""
    state: NDArray
    """(3, n_blocks, n) strain energy, hourglass energy [J], J - 1 of the elements."""
    viscous: NDArray
    """(n_blocks, n_prony + 1, 6, n) history of the relaxing stress."""
    registers: tuple[NDArray, NDArray, NDArray, NDArray]
    """`u`, `v`, `force` and `mobility` again, as rows (n_rows, n) of one register each."""


class Platens(NamedTuple):
    """What holds the sample."""

    glued: tuple[NDArray, NDArray]
    """int32 ids of the nodes that the base and the moving platen hold for good."""
    candidates: NDArray
    """int32 ids of the nodes that may touch a platen."""
    planes: NDArray
    """(2, 4) base and moving platen at zero travel: unit normal from the sample into the platen,
    offset [m]; an infinite offset switches a platen's contact off."""
    ball: NDArray
    """(4,) centre at zero travel and radius [m] of a ball that stands for the moving platen; a
    radius of zero stands for the plane."""
    friction: NDArray
    """(2,) coefficients of Coulomb friction in contact with base and moving platen; infinite
    for no slip."""
    direction: NDArray
    """(3,) unit vector of the moving platen's travel."""
    spin: float
    """Angle by which the moving platen turns about the z axis over its travel [rad/m]; zero for one
    that does not turn. Forces along the direction are then torques times this."""
    release: bool
    """Whether a touching node releases a platen that would have to pull on it."""
    mobile: NDArray
    """(3,) one for an axis along which nodes may move, zero where walls without friction keep
    every node from moving; what the walls bear is no force of a platen."""


@compiled
def advance(path, gravity, relax, dt, dt_before, motion, elements, solid, platens, history, lane):
    """March the central difference scheme over ``len(path) - 1`` equal steps.

    Parameters
    ----------
    path : (n_steps + 1,) float64
        Travel of the moving platen [m] at the start of each step and at the end.
    gravity : (n_steps, 3) float64
        Acceleration [m/s2] that stands for the body force, during each step.
    relax : (n_steps, 2, n_prony) float64
        See `internal_force`.
    dt, dt_before : float
        This slice's time step and that of the step before it [s].
    motion, elements, solid, platens
        `motion` is changed in place.
    history : (n_steps, 7) float64
        Per step: force of the moving platen and of the base on the sample [N], work of the body
        force less that lost in friction [J]; overwritten.
    lane : None or int
        See `internal_force`.
    """
    u, force = motion.u, motion.force
    steps = path.size - 1
    force[:] = 0.0
    for step in range(steps):
        last = step == steps - 1
        add_forces(u, elements, solid, relax[step], motion.viscous, force, motion.state, last, lane)
        kick = 0.5 * (dt + dt_before)
        rate, speed = 1.0 / kick, (path[step + 1] - path[step]) / dt
        record = history[step]
        record[:] = 0.0
        if gravity[step, 0] != 0.0 or gravity[step, 1] != 0.0 or gravity[step, 2] != 0.0:
            record[6] += _weigh(gravity[step], dt, motion)
        if platens.spin > 0.0:
            _turn(BASE, rate, dt, 0.0, motion, platens, record)
            _turn(PLATEN, rate, dt, platens.spin * path[step + 1], motion, platens, record)
        else:
            velocity = _times(speed, platens.direction)
            _carry(platens.glued[0], rate, (0.0, 0.0, 0.0), motion, platens.mobile, record, BASE)
            _carry(platens.glued[1], rate, velocity, motion, platens.mobile, record, PLATEN)
        for node in platens.candidates:
            if motion.held[node] != FREE:
                _press(node, kick, path[step], speed, dt, motion, platens, record)
        _move(motion.registers, kick, dt, last, lane)
        for node in platens.candidates:
            if motion.held[node] == FREE:
                _catch(node, BASE, 0.0, dt, kick, motion, platens, record)
            if motion.held[node] == FREE:
                _catch(node, PLATEN, path[step + 1], dt, kick, motion, platens, record)
        dt_before = dt


@inline
def _weigh(gravity, dt, motion):
    """Take the body force off the internal force; its work over the last step [J]."""
    work = 0.0
    for node in range(motion.mass.size):
        for i in range(3):
            weight = motion.mass[node] * gravity[i]
            motion.force[node, i] -= weight
            work += weight * motion.v[node, i] * dt
    return work


@inline
def _move(registers, kick, dt, last, lane):
    """Kick and drift all nodes and clear the forces; held ones keep the velocity set for them."""
    for row in range(registers[0].shape[0]):
        if lane is None:
            _move_row(registers, kick, dt, last, row, None)
        else:
            for k in range(registers[0].shape[1]):
                _move_row(registers, kick, dt, last, row, k)


@inline
def _move_row(registers, kick, dt, last, row, lane):
    u, v, force, mobility = registers
    f = load(force, (row,), lane)
    speed = load(v, (row,), lane) - like(f, kick) * load(mobility, (row,), lane) * f
    store(v, (row,), lane, speed)
    store(u, (row,), lane, load(u, (row,), lane) + like(f, dt) * speed)
    if not last:
        store(force, (row,), lane, like(f, 0.0))


@inline
def _times(k, a):
    return k * a[0], k * a[1], k * a[2]


@inline
def _each(a, b):
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


@inline
def _reaction(node, rate, velocity, motion):
    """Force of the platen on a held node [N]: its force plus mass times acceleration."""
    inertia, force, v = motion.mass[node] * rate, motion.force, motion.v
    return (
        force[node, 0] + inertia * (velocity[0] - v[node, 0]),
        force[node, 1] + inertia * (velocity[1] - v[node, 1]),
        force[node, 2] + inertia * (velocity[2] - v[node, 2]),
    )


@inline
def _add3(row, first, k, b):
    """Add to three numbers of a row k times three others."""
    row[first] += k * b[0]
    row[first + 1] += k * b[1]
    row[first + 2] += k * b[2]


@inline
def _column(holder):
    """First column of `history` for the forces of a platen."""
    return 0 if holder == PLATEN else 3


@inline
def _carry(nodes, rate, velocity, motion, mobile, record, holder):
    """Give glued nodes their platen's velocity and record the force that this takes."""
    x = y = z = 0.0
    for node in nodes:
        a, b, c = _reaction(node, rate, velocity, motion)
        x, y, z = x + a, y + b, z + c
        motion.v[node, 0], motion.v[node, 1], motion.v[node, 2] = velocity
    _add3(record, _column(holder), 1.0, _each((x, y, z), mobile))


@inline
def _turn(holder, rate, dt, angle, motion, platens, record):
    """Turn glued nodes about the z axis to an angle; record torque times spin, and axial force."""
    cosine, sine = np.cos(angle), np.sin(angle)
    around = along = 0.0
    for node in platens.glued[holder - 1]:
        first, second = motion.points[node, 0], motion.points[node, 1]
        x, y = first + motion.u[node, 0], second + motion.u[node, 1]
        velocity = (
            (cosine * first - sine * second - x) / dt,
            (sine * first + cosine * second - y) / dt,
            0.0,
        )
        a, b, c = _reaction(node, rate, velocity, motion)
        around, along = around + platens.spin * (x * b - y * a), along + c
        motion.v[node, 0], motion.v[node, 1], motion.v[node, 2] = velocity
    _add3(record, _column(holder), 1.0, (around, 0.0, along))


@inline
def _contact(node, holder, travel, motion, platens):
    """Unit normal from the sample into a platen where a node meets it, and how far [m] it is in."""
    x = (
        motion.points[node, 0] + motion.u[node, 0],
        motion.points[node, 1] + motion.u[node, 1],
        motion.points[node, 2] + motion.u[node, 2],
    )
    if holder == PLATEN and platens.ball[3] > 0.0:
        way = (
            platens.ball[0] + travel * platens.direction[0] - x[0],
            platens.ball[1] + travel * platens.direction[1] - x[1],
            platens.ball[2] + travel * platens.direction[2] - x[2],
        )
        distance = np.sqrt(dot(way, way))
        return _times(1.0 / distance, way), platens.ball[3] - distance
    n = platens.planes[holder - 1]
    gap = -n[3] - travel * dot(n, platens.direction)
    for i in range(3):
        gap += x[i] * n[i]
    return (n[0], n[1], n[2]), gap


@inline
def _press(node, kick, travel, speed, dt, motion, platens, record):
    """Hold a touching node as long as its platen pushes, with no more than friction sideways."""
    holder = motion.held[node]
    n, gap = _contact(node, holder, travel, motion, platens)
    velocity = _times(speed if holder == PLATEN else 0.0, platens.direction)
    push = _each(_reaction(node, 1.0 / kick, velocity, motion), platens.mobile)
    pull = dot(push, n)
    if platens.release and pull > 0.0:
        motion.held[node] = FREE
        for i in range(3):
            motion.mobility[node, i] = platens.mobile[i] / motion.mass[node]
        return
    motion.v[node, 0], motion.v[node, 1], motion.v[node, 2] = velocity
    _add3(record, _column(holder), 1.0, push)
    if platens.friction[holder - 1] < np.inf:
        sideways = push[0] - pull * n[0], push[1] - pull * n[1], push[2] - pull * n[2]
        size = np.sqrt(dot(sideways, sideways))
        limit = platens.friction[holder - 1] * max(-pull, 0.0)
        if size > limit:
            excess = 1.0 - limit / size
            mobility = excess * kick / motion.mass[node]
            _add3(record, _column(holder), -excess, sideways)
            _add3(motion.v[node], 0, -mobility, sideways)
            record[6] -= limit * mobility * size * dt
        if holder == PLATEN and platens.ball[3] > 0.0:  # back from the tangent onto the ball
            _add3(motion.v[node], 0, -gap / dt, n)


@inline
def _catch(node, holder, travel, dt, kick, motion, platens, record):
    """Stop a free node at the platen it has just passed; it is held from then on."""
    n, gap = _contact(node, holder, travel, motion, platens)
    if gap > 0.0:
        motion.held[node] = holder
        for i in range(3):
            motion.mobility[node, i] = 0.0
        _add3(motion.u[node], 0, -gap, n)
        _add3(motion.v[node], 0, -gap / dt, n)
        _add3(record, _column(holder), -gap * motion.mass[node] / dt / kick, n)
