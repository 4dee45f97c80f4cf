"""Nodal forces of one-point hexahedra, compiled.

Elements are processed in blocks, one element per vector lane. With `lane` None every value below
stands for a whole block (see `softsample.fem.lanes`); with an integer for one element of it: the
same text is the fast kernel and its plain twin. `tests/naive.py` says it once more, with NumPy.
"""

from typing import NamedTuple

from numpy.typing import NDArray

from softsample.fem.lanes import compiled, gather, inline, like, load, scatter_add, store
from softsample.fem.stress import stress_of
from softsample.fem.tensors import dot


class Elements(NamedTuple):
    """Elements in blocks of n lanes; the last block is filled up with elements of no weight.

    Blocks of parallelepipeds come first: their mean gradients are sums of three vectors, and no
    hourglass pattern has a linear part, so that they need fewer numbers.
    """

    connectivity: NDArray
    """(n_blocks, 8, n) int32."""
    grouped: NDArray
    """(n_blocks,) bool: whether in each group of n/4 lanes the nodes follow one another."""
    slopes: NDArray
    """(n_regular, 3, 3, n) gradients of the natural coordinates over 8 [1/m]."""
    gradient: NDArray
    """(n_blocks - n_regular, 8, 3, n) mean gradients of the shape functions [1/m]."""
    hourglass: NDArray
    """(n_blocks - n_regular, 4, 3, n) linear part of the hourglass patterns [m]."""
    volume: NDArray
    """(n_blocks, n) volume times relative stiffness [m3]."""
    stiffness: NDArray
    """(n_blocks, n) hourglass stiffness [N/m]."""


@inline
def _gather8(u, elements, block, lane):
    """Displacements of the eight corners: eight of x, of y and of z."""
    nodes, grouped = elements.connectivity, elements.grouped[block]
    a = gather(u, nodes, (block, 0), lane, grouped)
    b = gather(u, nodes, (block, 1), lane, grouped)
    c = gather(u, nodes, (block, 2), lane, grouped)
    d = gather(u, nodes, (block, 3), lane, grouped)
    e = gather(u, nodes, (block, 4), lane, grouped)
    f = gather(u, nodes, (block, 5), lane, grouped)
    g = gather(u, nodes, (block, 6), lane, grouped)
    h = gather(u, nodes, (block, 7), lane, grouped)
    return (
        (a[0], b[0], c[0], d[0], e[0], f[0], g[0], h[0]),
        (a[1], b[1], c[1], d[1], e[1], f[1], g[1], h[1]),
        (a[2], b[2], c[2], d[2], e[2], f[2], g[2], h[2]),
    )


@inline
def _patterns(a):
    """Sums over the corners by sign patterns: xi, eta, zeta; eta zeta, zeta xi, xi eta, all three.

    A Walsh-Hadamard transform without its mean.
    """
    s0, s1, s2, s3 = a[0] + a[4], a[1] + a[5], a[2] + a[6], a[3] + a[7]
    d0, d1, d2, d3 = a[4] - a[0], a[5] - a[1], a[6] - a[2], a[7] - a[3]
    low, high = s1 - s0, s2 - s3
    left, right = d1 - d0, d2 - d3
    front, back = d0 + d1, d3 + d2
    return (
        (low + high, (s3 + s2) - (s0 + s1), front + back),
        (back - front, left + right, high - low, right - left),
    )


@inline
def _corners(linear, twisted):
    """Transpose of `_patterns`: eight corners from three linear and four hourglass amplitudes."""
    x, y, z = linear
    yz, zx, xy, xyz = twisted
    high, low = x + xy, x - xy
    s0, s1, s2, s3 = -y - low, low - y, y + high, y - high
    front, back, left, right = z - yz, z + yz, zx - xyz, zx + xyz
    d0, d1, d2, d3 = front - left, front + left, back + right, back - right
    return s0 - d0, s1 - d1, s2 - d2, s3 - d3, s0 + d0, s1 + d1, s2 + d2, s3 + d3


@inline
def _row3(array, index, lane):
    """Three numbers per lane."""
    return (
        load(array, (index[0], index[1], 0), lane),
        load(array, (index[0], index[1], 1), lane),
        load(array, (index[0], index[1], 2), lane),
    )


@inline
def _rows3(array, block, lane):
    """Three times three numbers per lane."""
    return (
        _row3(array, (block, 0), lane),
        _row3(array, (block, 1), lane),
        _row3(array, (block, 2), lane),
    )


@inline
def _outer_sum(x, y, z, g):
    """Matrix (9, row by row) sum_m (x_m, y_m, z_m) g_m of three vectors and their gradients."""
    (a, b, c), (d, e, f), (p, q, r) = g
    return (
        x[0] * a + x[1] * d + x[2] * p, x[0] * b + x[1] * e + x[2] * q,
        x[0] * c + x[1] * f + x[2] * r,
        y[0] * a + y[1] * d + y[2] * p, y[0] * b + y[1] * e + y[2] * q,
        y[0] * c + y[1] * f + y[2] * r,
        z[0] * a + z[1] * d + z[2] * p, z[0] * b + z[1] * e + z[2] * q,
        z[0] * c + z[1] * f + z[2] * r,
    )  # fmt: skip


@inline
def _gradient(x, y, z, array, block, lane):
    """Displacement gradient (9, row by row) of corner displacements and mean gradients."""
    zero = like(x[0], 0.0)
    h = (zero, zero, zero, zero, zero, zero, zero, zero, zero)
    h = _add_corner(h, x[0], y[0], z[0], _row3(array, (block, 0), lane))
    h = _add_corner(h, x[1], y[1], z[1], _row3(array, (block, 1), lane))
    h = _add_corner(h, x[2], y[2], z[2], _row3(array, (block, 2), lane))
    h = _add_corner(h, x[3], y[3], z[3], _row3(array, (block, 3), lane))
    h = _add_corner(h, x[4], y[4], z[4], _row3(array, (block, 4), lane))
    h = _add_corner(h, x[5], y[5], z[5], _row3(array, (block, 5), lane))
    h = _add_corner(h, x[6], y[6], z[6], _row3(array, (block, 6), lane))
    return _add_corner(h, x[7], y[7], z[7], _row3(array, (block, 7), lane))


@inline
def _add_corner(h, x, y, z, b):
    p, q, r = b
    return (
        h[0] + x * p, h[1] + x * q, h[2] + x * r,
        h[3] + y * p, h[4] + y * q, h[5] + y * r,
        h[6] + z * p, h[7] + z * q, h[8] + z * r,
    )  # fmt: skip


@inline
def _without_linear_part(g, h, linear):
    """Amplitudes of four hourglass patterns of one component, less what its gradient h explains."""
    return (
        g[0] - dot(h, linear[0]), g[1] - dot(h, linear[1]),
        g[2] - dot(h, linear[2]), g[3] - dot(h, linear[3]),
    )  # fmt: skip


@inline
def _back_on_gradient(p, f, linear):
    """One row of the stress less the outer product of hourglass forces and linear parts."""
    a, b, c, d = linear
    return (
        p[0] - (f[0] * a[0] + f[1] * b[0] + f[2] * c[0] + f[3] * d[0]),
        p[1] - (f[0] * a[1] + f[1] * b[1] + f[2] * c[1] + f[3] * d[1]),
        p[2] - (f[0] * a[2] + f[1] * b[2] + f[2] * c[2] + f[3] * d[2]),
    )


@inline
def _scaled(k, a):
    return k * a[0], k * a[1], k * a[2], k * a[3]


@inline
def _squares(a):
    return (a[0] * a[0] + a[1] * a[1]) + (a[2] * a[2] + a[3] * a[3])


@inline
def _note(state, block, lane, energy, k, gx, gy, gz, dilatation):
    """Strain energy, hourglass energy and J - 1."""
    twist = like(k, 0.5) * k * (_squares(gx) + _squares(gy) + _squares(gz))
    store(state, (0, block), lane, energy)
    store(state, (1, block), lane, twist)
    store(state, (2, block), lane, dilatation)


@inline
def _scatter8(force, elements, block, lane, x, y, z):
    """Add forces to the eight corners."""
    nodes, grouped = elements.connectivity, elements.grouped[block]
    scatter_add(force, nodes, (block, 0), lane, grouped, x[0], y[0], z[0])
    scatter_add(force, nodes, (block, 1), lane, grouped, x[1], y[1], z[1])
    scatter_add(force, nodes, (block, 2), lane, grouped, x[2], y[2], z[2])
    scatter_add(force, nodes, (block, 3), lane, grouped, x[3], y[3], z[3])
    scatter_add(force, nodes, (block, 4), lane, grouped, x[4], y[4], z[4])
    scatter_add(force, nodes, (block, 5), lane, grouped, x[5], y[5], z[5])
    scatter_add(force, nodes, (block, 6), lane, grouped, x[6], y[6], z[6])
    scatter_add(force, nodes, (block, 7), lane, grouped, x[7], y[7], z[7])


@inline
def _add_linear(x, p, array, block, lane):
    """Add to eight corners the product of a row of the stress and the mean gradients."""
    return (
        x[0] + dot(p, _row3(array, (block, 0), lane)),
        x[1] + dot(p, _row3(array, (block, 1), lane)),
        x[2] + dot(p, _row3(array, (block, 2), lane)),
        x[3] + dot(p, _row3(array, (block, 3), lane)),
        x[4] + dot(p, _row3(array, (block, 4), lane)),
        x[5] + dot(p, _row3(array, (block, 5), lane)),
        x[6] + dot(p, _row3(array, (block, 6), lane)),
        x[7] + dot(p, _row3(array, (block, 7), lane)),
    )


@inline
def add_regular(u, elements, solid, relax, viscous, force, state, watch, block, lane):
    """Add the forces of a parallelepiped, or of a block of them, and note their state."""
    x, y, z = _gather8(u, elements, block, lane)
    (x, gx), (y, gy), (z, gz) = _patterns(x), _patterns(y), _patterns(z)
    slopes = _rows3(elements.slopes, block, lane)
    h = _outer_sum(x, y, z, slopes)
    p, energy, dilatation = stress_of(h, elements, solid, relax, viscous, block, lane)
    k = load(elements.stiffness, (block,), lane)
    if watch:
        _note(state, block, lane, energy, k, gx, gy, gz, dilatation)
    a, b, c = slopes
    px, py, pz = (p[0], p[1], p[2]), (p[3], p[4], p[5]), (p[6], p[7], p[8])
    _scatter8(
        force, elements, block, lane,
        _corners((dot(px, a), dot(px, b), dot(px, c)), _scaled(k, gx)),
        _corners((dot(py, a), dot(py, b), dot(py, c)), _scaled(k, gy)),
        _corners((dot(pz, a), dot(pz, b), dot(pz, c)), _scaled(k, gz)),
    )  # fmt: skip


@inline
def _element(u, elements, solid, relax, viscous, force, state, watch, block, lane):
    """Add the forces of any element, or of a block of them, and note their state."""
    place = block - elements.slopes.shape[0]
    x, y, z = _gather8(u, elements, block, lane)
    gx, gy, gz = _patterns(x)[1], _patterns(y)[1], _patterns(z)[1]
    h = _gradient(x, y, z, elements.gradient, place, lane)
    p, energy, dilatation = stress_of(h, elements, solid, relax, viscous, block, lane)
    linear = (
        _row3(elements.hourglass, (place, 0), lane), _row3(elements.hourglass, (place, 1), lane),
        _row3(elements.hourglass, (place, 2), lane), _row3(elements.hourglass, (place, 3), lane),
    )  # fmt: skip
    gx = _without_linear_part(gx, (h[0], h[1], h[2]), linear)
    gy = _without_linear_part(gy, (h[3], h[4], h[5]), linear)
    gz = _without_linear_part(gz, (h[6], h[7], h[8]), linear)
    k = load(elements.stiffness, (block,), lane)
    if watch:
        _note(state, block, lane, energy, k, gx, gy, gz, dilatation)
    fx, fy, fz = _scaled(k, gx), _scaled(k, gy), _scaled(k, gz)
    px = _back_on_gradient((p[0], p[1], p[2]), fx, linear)
    py = _back_on_gradient((p[3], p[4], p[5]), fy, linear)
    pz = _back_on_gradient((p[6], p[7], p[8]), fz, linear)
    zero = like(k, 0.0)
    none = (zero, zero, zero)
    x, y, z = _corners(none, fx), _corners(none, fy), _corners(none, fz)
    _scatter8(
        force, elements, block, lane,
        _add_linear(x, px, elements.gradient, place, lane),
        _add_linear(y, py, elements.gradient, place, lane),
        _add_linear(z, pz, elements.gradient, place, lane),
    )  # fmt: skip


@compiled
def add_forces(u, elements, solid, relax, viscous, force, state, watch, lane):
    """Add the forces of all elements; see `internal_force`."""
    regular = elements.slopes.shape[0]
    for block in range(elements.connectivity.shape[0]):
        if lane is None:
            if block < regular:
                add_regular(u, elements, solid, relax, viscous, force, state, watch, block, None)
            else:
                _element(u, elements, solid, relax, viscous, force, state, watch, block, None)
        else:
            for k in range(elements.connectivity.shape[2]):
                if block < regular:
                    add_regular(u, elements, solid, relax, viscous, force, state, watch, block, k)
                else:
                    _element(u, elements, solid, relax, viscous, force, state, watch, block, k)


@compiled
def internal_force(u, elements, solid, relax, viscous, force, state, watch, lane):
    """Sum of all element forces; returns nothing.

    Parameters
    ----------
    u : (n_nodes, 4) float32 or float64
        Displacements [m] in the first three columns; the fourth keeps rows aligned.
    elements : Elements
        Arrays in the dtype of `u`.
    solid : Solid
        Material; its Prony terms act on the stress of an elastic solid of moduli `mu`.
    relax : (2, n_prony) float64
        Decay of the history over this step and gain of new stress, per Prony term.
    viscous : (n_blocks, n_prony + 1, 6, n), dtype of `u`
        Volume times second Piola-Kirchhoff stress of the step before, then the history variables.
    force : (n_nodes, 4), dtype of `u`
        Internal nodal forces [N], overwritten: the resistance of the elements to `u`.
    state : (3, n_blocks, n), dtype of `u`
        Strain energy [J], hourglass energy [J] and J - 1 of each element, if `watch`.
    watch : bool
        Whether to write `state`.
    lane : None or int
        None for vector code; any number for its scalar twin.
    """
    force[:] = 0.0
    add_forces(u, elements, solid, relax, viscous, force, state, watch, lane)
