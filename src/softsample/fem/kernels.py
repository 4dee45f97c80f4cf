"""Compiled kernels of the explicit solver; arguments are checked by `softsample.fem.explicit`.

Elements are processed in blocks, one element per vector lane. With `lane` None every value below
stands for a whole block (see `softsample.fem.lanes`); with an integer for one element of it: the
same text is the fast kernel and its plain twin. `tests/naive.py` says it once more, with NumPy.
All kernels live in this file because a cached kernel does not notice an edit of a callee elsewhere.
"""

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from softsample.fem.element import HOURGLASS
from softsample.fem.lanes import (
    copysign,
    exp,
    gather,
    like,
    load,
    log,
    maximum,
    reciprocal_sqrt,
    scatter_add,
    store,
)

FREE, BASE, PLATEN = 0, 1, 2
"""What holds a node: nothing, the fixed base platen, the moving platen."""

SIGNS = np.ascontiguousarray(HOURGLASS.T, dtype=np.float32)
"""Signs of the four hourglass patterns at the eight corners, (8, 4)."""

TINY = 1e-18
"""Keeps the angle of a rotation defined where there is nothing to rotate."""

_inline = numba.njit(forceinline=True, error_model="numpy", _nrt=False)
# Without reference counting of arrays (`_nrt`), which costs a third inside these loops.


class Elements(NamedTuple):
    """Elements in blocks of n lanes; the last block is filled up with elements of no weight."""

    connectivity: NDArray
    """(n_blocks, 8, n) int32."""
    gradient: NDArray
    """(n_blocks, 8, 3, n) mean gradients of the shape functions [1/m]."""
    hourglass: NDArray
    """(n_blocks, 4, 3, n) linear part of the hourglass patterns [m]."""
    volume: NDArray
    """(n_blocks, n) volume times relative stiffness [m3]."""
    stiffness: NDArray
    """(n_blocks, n) hourglass stiffness [N/m]."""


class Solid(NamedTuple):
    """What the elements are made of."""

    mu: NDArray
    """(n_terms,) float64 moduli [Pa]."""
    alpha: NDArray
    """(n_terms,) float64 exponents, by ascending magnitude."""
    bulk: float
    """Bulk modulus [Pa]."""
    sweeps: int
    """Zero for even exponents, otherwise how many Jacobi sweeps find the eigenvalues."""
    fibre: NDArray
    """(4,) float64: modulus k1 [Pa] of ``W = k1 (I4bar - 1)^2``, unit direction."""
    prony: NDArray
    """(n_prony,) float64: relaxing parts g of the isochoric stress, sum below one."""


# --- one element, or one block of elements ------------------------------------------------------


@_inline
def _gradients(u, elements, block, lane):
    """Displacement gradient h (9, row by row) and hourglass sums g (4 patterns of 3 components)."""
    zero = like(load(elements.volume, (block,), lane), 0.0)
    h00 = h01 = h02 = h10 = h11 = h12 = h20 = h21 = h22 = zero
    g00 = g01 = g02 = g10 = g11 = g12 = g20 = g21 = g22 = g30 = g31 = g32 = zero
    for a in range(8):
        x, y, z = gather(u, elements.connectivity, (block, a), lane)
        p = load(elements.gradient, (block, a, 0), lane)
        q = load(elements.gradient, (block, a, 1), lane)
        r = load(elements.gradient, (block, a, 2), lane)
        h00, h01, h02 = h00 + x * p, h01 + x * q, h02 + x * r
        h10, h11, h12 = h10 + y * p, h11 + y * q, h12 + y * r
        h20, h21, h22 = h20 + z * p, h21 + z * q, h22 + z * r
        s, t, v, w = SIGNS[a, 0], SIGNS[a, 1], SIGNS[a, 2], SIGNS[a, 3]
        g00, g01, g02 = g00 + x * s, g01 + y * s, g02 + z * s
        g10, g11, g12 = g10 + x * t, g11 + y * t, g12 + z * t
        g20, g21, g22 = g20 + x * v, g21 + y * v, g22 + z * v
        g30, g31, g32 = g30 + x * w, g31 + y * w, g32 + z * w
    return (
        (h00, h01, h02, h10, h11, h12, h20, h21, h22),
        ((g00, g01, g02), (g10, g11, g12), (g20, g21, g22), (g30, g31, g32)),
    )


@_inline
def _cofactors(h):
    """Cofactors (9, row by row) of F = I + h and J - 1, formed from h to keep their digits."""
    a, b, d, e, f, g, p, q, r = h
    one = like(a, 1.0)
    A, F, R = one + a, one + f, one + r
    minors = (f * r - g * q) + (a * r - d * p) + (a * f - b * e)
    cubic = a * (f * r - g * q) - b * (e * r - g * p) + d * (e * q - f * p)
    return (
        (F * R - g * q, g * p - e * R, e * q - F * p,
         d * q - b * R, A * R - d * p, b * p - A * q,
         b * g - d * F, d * e - A * g, A * F - b * e),
        (a + f + r) + minors + cubic,
    )  # fmt: skip


@_inline
def _inverse_square_cube_root(dilatation):
    """J^(-2/3) by Newton's iteration for J^(-1/3), quadratic and free of branches."""
    third, four = like(dilatation, 1.0 / 3.0), like(dilatation, 4.0)
    J = like(dilatation, 1.0) + dilatation
    y = maximum(like(dilatation, 1.0) - third * dilatation, third)
    for _ in range(5):
        y = y * (four - J * y * y * y) * third
    return y * y


@_inline
def _cauchy_green(h, scale):
    """scale C = scale (I + h)^T (I + h), symmetric: xx, yy, zz, yz, zx, xy."""
    a, b, d, e, f, g, p, q, r = h
    one = like(a, 1.0)
    return (
        scale * (one + (a + a + a * a + e * e + p * p)),
        scale * (one + (f + f + b * b + f * f + q * q)),
        scale * (one + (r + r + d * d + g * g + r * r)),
        scale * (g + q + b * d + f * g + q * r),
        scale * (d + p + d * a + g * e + r * p),
        scale * (b + e + a * b + e * f + p * q),
    )


@_inline
def _product(a, b):
    """a b of symmetric matrices that commute."""
    xx, yy, zz, yz, zx, xy = a
    XX, YY, ZZ, YZ, ZX, XY = b
    return (
        xx * XX + xy * XY + zx * ZX,
        xy * XY + yy * YY + yz * YZ,
        zx * ZX + yz * YZ + zz * ZZ,
        xy * ZX + yy * YZ + yz * ZZ,
        zx * XX + yz * XY + zz * ZX,
        xx * XY + xy * YY + zx * YZ,
    )


@_inline
def _adjugate(a):
    """adj(a), the inverse of a symmetric matrix of determinant one."""
    xx, yy, zz, yz, zx, xy = a
    return (
        yy * zz - yz * yz,
        zz * xx - zx * zx,
        xx * yy - xy * xy,
        zx * xy - xx * yz,
        xy * yz - yy * zx,
        yz * zx - zz * xy,
    )


@_inline
def _whole_power(a, n):
    """a^n for a whole n > 0, by squaring."""
    while n & 1 == 0:
        a = _product(a, a)
        n >>= 1
    power = a
    n >>= 1
    while n > 0:
        a = _product(a, a)
        if n & 1:
            power = _product(power, a)
        n >>= 1
    return power


@_inline
def _rotation(p, q, off):
    """Cosine, sine and tangent of the Jacobi rotation, at most 45 degrees, that annuls `off`."""
    half, difference = like(off, 0.5), q - p
    gap = copysign(difference, half) + like(off, TINY)
    r = reciprocal_sqrt(gap * gap + like(off, 4.0) * off * off)
    square = half + half * gap * r
    root = reciprocal_sqrt(square)
    sine = copysign(off * r * root, difference * off)
    return square * root, sine, sine * root


@_inline
def _rotate(c, s, x, y):
    return c * x - s * y, s * x + c * y


@_inline
def _eigen(a, sweeps):
    """Eigenvalues (3) and eigenvectors (3 of 3 components) of a symmetric matrix, cyclic Jacobi."""
    xx, yy, zz, yz, zx, xy = a
    one, zero = like(xx, 1.0), like(xx, 0.0)
    m0 = n1 = o2 = one
    m1 = m2 = n0 = n2 = o0 = o1 = zero
    for _ in range(sweeps):
        c, s, t = _rotation(xx, yy, xy)
        shift = t * xy
        xx, yy, xy = xx - shift, yy + shift, zero
        zx, yz = _rotate(c, s, zx, yz)
        m0, n0 = _rotate(c, s, m0, n0)
        m1, n1 = _rotate(c, s, m1, n1)
        m2, n2 = _rotate(c, s, m2, n2)
        c, s, t = _rotation(yy, zz, yz)
        shift = t * yz
        yy, zz, yz = yy - shift, zz + shift, zero
        xy, zx = _rotate(c, s, xy, zx)
        n0, o0 = _rotate(c, s, n0, o0)
        n1, o1 = _rotate(c, s, n1, o1)
        n2, o2 = _rotate(c, s, n2, o2)
        c, s, t = _rotation(xx, zz, zx)
        shift = t * zx
        xx, zz, zx = xx - shift, zz + shift, zero
        xy, yz = _rotate(c, s, xy, yz)
        m0, o0 = _rotate(c, s, m0, o0)
        m1, o1 = _rotate(c, s, m1, o1)
        m2, o2 = _rotate(c, s, m2, o2)
    return (xx, yy, zz), ((m0, m1, m2), (n0, n1, n2), (o0, o1, o2))


@_inline
def _dyad(w, n):
    """w n n, symmetric."""
    x, y, z = n
    wx, wy, wz = w * x, w * y, w * z
    return (wx * x, wy * y, wz * z, wy * z, wz * x, wx * y)


@_inline
def _sum(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]


@_inline
def _add_term(mandel, energy, power, mu, alpha):
    """Add an Ogden term, given Cbar^(alpha/2), to isochoric Mandel stress and strain energy."""
    trace = power[0] + power[1] + power[2]
    mean = like(trace, 1.0 / 3.0) * trace
    f = like(trace, 2.0 * mu / alpha)
    mandel = (
        mandel[0] + f * (power[0] - mean),
        mandel[1] + f * (power[1] - mean),
        mandel[2] + f * (power[2] - mean),
        mandel[3] + f * power[3],
        mandel[4] + f * power[4],
        mandel[5] + f * power[5],
    )
    return mandel, energy + like(trace, 2.0 * mu / alpha**2) * (trace - like(trace, 3.0))


@_inline
def _ogden(c, solid):
    """Isochoric Mandel stress and strain energy of all Ogden terms, from Cbar."""
    zero = like(c[0], 0.0)
    mandel, energy = (zero, zero, zero, zero, zero, zero), zero
    if solid.sweeps > 0:
        values, vectors = _eigen(c, solid.sweeps)
        x, y = log(values[0]), log(values[1])
        z = zero - x - y  # det Cbar = 1
        for k in range(solid.mu.size):
            half = like(zero, 0.5 * solid.alpha[k])
            first, second = _dyad(exp(half * x), vectors[0]), _dyad(exp(half * y), vectors[1])
            power = _sum(_sum(first, second), _dyad(exp(half * z), vectors[2]))
            mandel, energy = _add_term(mandel, energy, power, solid.mu[k], solid.alpha[k])
    else:
        base, reached = c, 1
        for k in range(solid.mu.size):
            n = abs(int(solid.alpha[k])) // 2
            if n % reached:
                base, reached = c, 1
            base = _whole_power(base, n // reached)
            reached = n
            power = _adjugate(base) if solid.alpha[k] < 0.0 else base
            mandel, energy = _add_term(mandel, energy, power, solid.mu[k], solid.alpha[k])
    return mandel, energy


@_inline
def _pull_back(cofactor, jacobian, stress):
    """Second Piola-Kirchhoff stress F^-1 P, symmetric, of a nominal stress (9, row by row)."""
    a, b, c, d, e, f, g, p, q = cofactor
    A, B, C, D, E, F, G, P, Q = stress
    scale = like(a, 1.0) / jacobian
    return (
        scale * (a * A + d * D + g * G),
        scale * (b * B + e * E + p * P),
        scale * (c * C + f * F + q * Q),
        scale * (b * C + e * F + p * Q),
        scale * (c * A + f * D + q * G),
        scale * (a * B + d * E + g * P),
    )


@_inline
def _push(h, s):
    """F S (9, row by row) of a symmetric S, F = I + h."""
    a, b, d, e, f, g, p, q, r = h
    xx, yy, zz, yz, zx, xy = s
    one = like(a, 1.0)
    A, F, R = one + a, one + f, one + r
    return (
        A * xx + b * xy + d * zx, A * xy + b * yy + d * yz, A * zx + b * yz + d * zz,
        e * xx + F * xy + g * zx, e * xy + F * yy + g * yz, e * zx + F * yz + g * zz,
        p * xx + q * xy + R * zx, p * xy + q * yy + R * yz, p * zx + q * yz + R * zz,
    )  # fmt: skip


@_inline
def _combine(x, a, y, b):
    """x a + y b of symmetric matrices."""
    return (
        x * a[0] + y * b[0], x * a[1] + y * b[1], x * a[2] + y * b[2],
        x * a[3] + y * b[3], x * a[4] + y * b[4], x * a[5] + y * b[5],
    )  # fmt: skip


@_inline
def _add_scaled(a, x, b):
    """a + x b of matrices (9, row by row)."""
    return (
        a[0] + x * b[0], a[1] + x * b[1], a[2] + x * b[2],
        a[3] + x * b[3], a[4] + x * b[4], a[5] + x * b[5],
        a[6] + x * b[6], a[7] + x * b[7], a[8] + x * b[8],
    )  # fmt: skip


@_inline
def _fall_inverse(cofactor, scale, mandel):
    """scale cof(F) M (9, row by row) of a symmetric M."""
    a, b, c, d, e, f, g, p, q = cofactor
    xx, yy, zz, yz, zx, xy = mandel
    a, b, c, d, e, f = scale * a, scale * b, scale * c, scale * d, scale * e, scale * f
    g, p, q = scale * g, scale * p, scale * q
    return (
        a * xx + b * xy + c * zx, a * xy + b * yy + c * yz, a * zx + b * yz + c * zz,
        d * xx + e * xy + f * zx, d * xy + e * yy + f * yz, d * zx + e * yz + f * zz,
        g * xx + p * xy + q * zx, g * xy + p * yy + q * yz, g * zx + p * yz + q * zz,
    )  # fmt: skip


@_inline
def _fibres(h, c, scale, solid):
    """Fibre stress in two parts, mean Mandel stress and nominal stress of (F a) a, and energy.

    S = 2 W' J^(-2/3) (a a - (a . C a) C^-1 / 3) with W' = 2 k1 (I4bar - 1).
    """
    modulus = like(scale, solid.fibre[0])
    x, y, z = like(scale, solid.fibre[1]), like(scale, solid.fibre[2]), like(scale, solid.fibre[3])
    two = like(scale, 2.0)
    square = c[0] * x * x + c[1] * y * y + c[2] * z * z
    square = square + two * (c[3] * y * z + c[4] * z * x + c[5] * x * y)
    strain = square - like(scale, 1.0)
    pull = two * two * modulus * strain
    nominal = _push(h, _dyad(pull * scale, (x, y, z)))
    return like(scale, -1.0 / 3.0) * pull * square, nominal, modulus * strain * strain


@_inline
def _load6(array, index, lane):
    return (
        load(array, (index[0], index[1], 0), lane), load(array, (index[0], index[1], 1), lane),
        load(array, (index[0], index[1], 2), lane), load(array, (index[0], index[1], 3), lane),
        load(array, (index[0], index[1], 4), lane), load(array, (index[0], index[1], 5), lane),
    )  # fmt: skip


@_inline
def _store6(array, index, lane, a):
    store(array, (index[0], index[1], 0), lane, a[0])
    store(array, (index[0], index[1], 1), lane, a[1])
    store(array, (index[0], index[1], 2), lane, a[2])
    store(array, (index[0], index[1], 3), lane, a[3])
    store(array, (index[0], index[1], 4), lane, a[4])
    store(array, (index[0], index[1], 5), lane, a[5])


@_inline
def _relax(elastic, prony, relax, viscous, block, lane):
    """Relaxed second Piola-Kirchhoff stress; brings the history of every Prony term up to date.

    H <- exp(-dt/tau) H + g tau/dt (1 - exp(-dt/tau)) (S - S before): exact for S linear in time.
    """
    one = like(elastic[0], 1.0)
    before = _load6(viscous, (block, 0), lane)
    _store6(viscous, (block, 0), lane, elastic)
    growth = _combine(one, elastic, like(one, -1.0), before)
    lasting = 1.0
    for n in range(prony.size):
        lasting -= prony[n]
    total = _combine(like(one, lasting), elastic, like(one, 0.0), elastic)
    for n in range(prony.size):
        history = _load6(viscous, (block, n + 1), lane)
        history = _combine(like(one, relax[0, n]), history, like(one, relax[1, n]), growth)
        _store6(viscous, (block, n + 1), lane, history)
        total = _combine(one, total, one, history)
    return total


@_inline
def _stress(h, elements, solid, relax, viscous, block, lane):
    """Volume times nominal stress (9), volume times strain energy density, and J - 1."""
    cofactor, dilatation = _cofactors(h)
    scale = _inverse_square_cube_root(dilatation)
    c = _cauchy_green(h, scale)
    mandel, energy = _ogden(c, solid)
    volume = load(elements.volume, (block,), lane)
    jacobian = like(scale, 1.0) + dilatation
    if solid.fibre[0] != 0.0:
        mean, nominal, more = _fibres(h, c, scale, solid)
        mandel = (
            mandel[0] + mean, mandel[1] + mean, mandel[2] + mean, mandel[3], mandel[4], mandel[5]
        )  # fmt: skip
        stress = _fall_inverse(cofactor, volume / jacobian, mandel)
        stress, energy = _add_scaled(stress, volume, nominal), energy + more
    else:
        stress = _fall_inverse(cofactor, volume / jacobian, mandel)
    if solid.prony.size > 0:
        elastic = _pull_back(cofactor, jacobian, stress)
        stress = _push(h, _relax(elastic, solid.prony, relax, viscous, block, lane))
    pressure = like(scale, solid.bulk) * dilatation
    energy = volume * (energy + like(scale, 0.5) * pressure * dilatation)
    return _add_scaled(stress, volume * pressure, cofactor), energy, dilatation


@_inline
def _resist(g, h, elements, block, m, lane):
    """Force of hourglass pattern m (3), its linear part (3) and its energy."""
    p = load(elements.hourglass, (block, m, 0), lane)
    q = load(elements.hourglass, (block, m, 1), lane)
    r = load(elements.hourglass, (block, m, 2), lane)
    k = load(elements.stiffness, (block,), lane)
    x = g[0] - (h[0] * p + h[1] * q + h[2] * r)
    y = g[1] - (h[3] * p + h[4] * q + h[5] * r)
    z = g[2] - (h[6] * p + h[7] * q + h[8] * r)
    return (k * x, k * y, k * z), (p, q, r), like(k, 0.5) * k * (x * x + y * y + z * z)


@_inline
def _without_linear_part(stress, f, linear):
    """Stress less the outer product of a hourglass force and the linear part of its pattern."""
    a, b, d, e, g, h, p, q, r = stress
    x, y, z = linear
    return (
        a - f[0] * x, b - f[0] * y, d - f[0] * z,
        e - f[1] * x, g - f[1] * y, h - f[1] * z,
        p - f[2] * x, q - f[2] * y, r - f[2] * z,
    )  # fmt: skip


@_inline
def _element(u, elements, solid, relax, viscous, force, state, watch, block, lane):
    """Add the forces of one element, or of one block, and note its state."""
    h, g = _gradients(u, elements, block, lane)
    p, energy, dilatation = _stress(h, elements, solid, relax, viscous, block, lane)
    f0, linear, e0 = _resist(g[0], h, elements, block, 0, lane)
    p = _without_linear_part(p, f0, linear)
    f1, linear, e1 = _resist(g[1], h, elements, block, 1, lane)
    p = _without_linear_part(p, f1, linear)
    f2, linear, e2 = _resist(g[2], h, elements, block, 2, lane)
    p = _without_linear_part(p, f2, linear)
    f3, linear, e3 = _resist(g[3], h, elements, block, 3, lane)
    p = _without_linear_part(p, f3, linear)
    if watch:
        store(state, (0, block), lane, energy)
        store(state, (1, block), lane, (e0 + e1) + (e2 + e3))
        store(state, (2, block), lane, dilatation)
    for a in range(8):
        bx = load(elements.gradient, (block, a, 0), lane)
        by = load(elements.gradient, (block, a, 1), lane)
        bz = load(elements.gradient, (block, a, 2), lane)
        s, t, v, w = SIGNS[a, 0], SIGNS[a, 1], SIGNS[a, 2], SIGNS[a, 3]
        scatter_add(
            force, elements.connectivity, (block, a), lane,
            (p[0] * bx + p[1] * by + p[2] * bz)
            + ((f0[0] * s + f1[0] * t) + (f2[0] * v + f3[0] * w)),
            (p[3] * bx + p[4] * by + p[5] * bz)
            + ((f0[1] * s + f1[1] * t) + (f2[1] * v + f3[1] * w)),
            (p[6] * bx + p[7] * by + p[8] * bz)
            + ((f0[2] * s + f1[2] * t) + (f2[2] * v + f3[2] * w)),
        )  # fmt: skip


@numba.njit(cache=True, error_model="numpy", _nrt=False)
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
    for block in range(elements.connectivity.shape[0]):
        if lane is None:
            _element(u, elements, solid, relax, viscous, force, state, watch, block, None)
        else:
            for k in range(elements.connectivity.shape[2]):
                _element(u, elements, solid, relax, viscous, force, state, watch, block, k)


# --- time integration and platens ---------------------------------------------------------------


class Motion(NamedTuple):
    """State of the nodes and elements."""

    u: NDArray
    """(n_nodes, 4) displacements [m]; the fourth column is not used."""
    v: NDArray
    """(n_nodes, 4) velocities [m/s], half a step behind."""
    force: NDArray
    """(n_nodes, 4) internal less body force [N] of the last step."""
    mobility: NDArray
    """(n_nodes,) inverse mass of free nodes [1/kg], zero for held ones; dtype of `u`."""
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


class Platens(NamedTuple):
    """What holds the sample."""

    glued: NDArray
    """int32 ids of the nodes that are held for good."""
    candidates: NDArray
    """int32 ids of the nodes that may touch a platen."""
    planes: NDArray
    """(2, 4) base and moving platen at zero travel: unit normal from the sample into the platen,
    offset [m]; an infinite offset switches a platen's contact off."""
    friction: NDArray
    """(2,) coefficients of Coulomb friction in contact with base and moving platen; infinite
    for no slip."""
    direction: NDArray
    """(3,) unit vector of the moving platen's travel."""
    release: bool
    """Whether a touching node lets go of a platen that would have to pull on it."""


@numba.njit(cache=True, error_model="numpy", _nrt=False)
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
    u, v, force = motion.u, motion.v, motion.force
    approach = _dot(platens.planes[1], platens.direction)
    steps = path.size - 1
    for step in range(steps):
        watch = step == steps - 1
        internal_force(
            u, elements, solid, relax[step], motion.viscous, force, motion.state, watch, lane
        )
        kick = 0.5 * (dt + dt_before)
        speed = (path[step + 1] - path[step]) / dt
        record = history[step]
        record[:] = 0.0
        if gravity[step, 0] != 0.0 or gravity[step, 1] != 0.0 or gravity[step, 2] != 0.0:
            record[6] += _weigh(gravity[step], dt, motion)
        for node in platens.glued:
            _hold(node, kick, speed, motion, platens, record)
        for node in platens.candidates:
            if motion.held[node] != FREE:
                _press(node, kick, speed, dt, motion, platens, record)
        _move(u, v, force, motion.mobility, u.dtype.type(kick), u.dtype.type(dt))
        for node in platens.candidates:
            if motion.held[node] == FREE:
                _catch(node, BASE, 0.0, dt, kick, motion, platens, record)
            if motion.held[node] == FREE:
                shift = path[step + 1] * approach
                _catch(node, PLATEN, shift, dt, kick, motion, platens, record)
        dt_before = dt


@_inline
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@_inline
def _weigh(gravity, dt, motion):
    """Take the body force off the internal force; its work over the last step [J]."""
    work = 0.0
    for node in range(motion.mass.size):
        for i in range(3):
            weight = motion.mass[node] * gravity[i]
            motion.force[node, i] -= weight
            work += weight * motion.v[node, i] * dt
    return work


@_inline
def _move(u, v, force, mobility, kick, dt):
    """Kick and drift all nodes; held ones keep the velocity that was set for them."""
    for node in range(u.shape[0]):
        impulse = kick * mobility[node]
        for i in range(4):
            v[node, i] -= impulse * force[node, i]
            u[node, i] += dt * v[node, i]


@_inline
def _reaction(node, i, kick, speed, motion, platens):
    """Force of the platen on a held node [N]: its force plus mass times acceleration."""
    new = speed * platens.direction[i] if motion.held[node] == PLATEN else 0.0
    return motion.force[node, i] + motion.mass[node] * (new - motion.v[node, i]) / kick


@_inline
def _column(holder):
    """First column of `history` for the forces of a platen."""
    return 0 if holder == PLATEN else 3


@_inline
def _hold(node, kick, speed, motion, platens, record):
    """Give a held node its platen's velocity and record the force that this takes."""
    column = _column(motion.held[node])
    for i in range(3):
        record[column + i] += _reaction(node, i, kick, speed, motion, platens)
        motion.v[node, i] = speed * platens.direction[i] if column == 0 else 0.0


@_inline
def _press(node, kick, speed, dt, motion, platens, record):
    """Hold a touching node as long as its platen pushes, with no more than friction sideways."""
    holder = motion.held[node]
    n = platens.planes[holder - 1]
    x = _reaction(node, 0, kick, speed, motion, platens)
    y = _reaction(node, 1, kick, speed, motion, platens)
    z = _reaction(node, 2, kick, speed, motion, platens)
    pull = x * n[0] + y * n[1] + z * n[2]
    if platens.release and pull > 0.0:
        motion.held[node] = FREE
        motion.mobility[node] = 1.0 / motion.mass[node]
        return
    _hold(node, kick, speed, motion, platens, record)
    if platens.friction[holder - 1] < np.inf:
        x, y, z = x - pull * n[0], y - pull * n[1], z - pull * n[2]
        sideways = np.sqrt(x * x + y * y + z * z)
        limit = platens.friction[holder - 1] * max(-pull, 0.0)
        if sideways > limit:
            excess = 1.0 - limit / sideways
            mobility = excess * kick / motion.mass[node]
            column = _column(holder)
            record[column] -= excess * x
            record[column + 1] -= excess * y
            record[column + 2] -= excess * z
            motion.v[node, 0] -= mobility * x
            motion.v[node, 1] -= mobility * y
            motion.v[node, 2] -= mobility * z
            record[6] -= limit * mobility * sideways * dt


@_inline
def _catch(node, holder, shift, dt, kick, motion, platens, record):
    """Stop a free node at the platen it has just passed; it is held from then on."""
    n = platens.planes[holder - 1]
    gap = -n[3] - shift
    for i in range(3):
        gap += (motion.points[node, i] + motion.u[node, i]) * n[i]
    if gap > 0.0:
        motion.held[node] = holder
        motion.mobility[node] = 0.0
        column = _column(holder)
        for i in range(3):
            back = gap * n[i]
            motion.u[node, i] -= back
            motion.v[node, i] -= back / dt
            record[column + i] -= motion.mass[node] * back / dt / kick
