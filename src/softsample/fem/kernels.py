"""Compiled kernels of the explicit solver; arguments are checked by `softsample.fem.explicit`.

Elements are processed in blocks, one element per vector lane. With `lane` None every value below
stands for a whole block (see `softsample.fem.lanes`); with an integer for one element of it: the
same text is the fast kernel and its plain twin. `tests/naive.py` says it once more, with NumPy.
All kernels live in this file because a cached kernel does not notice an edit of a callee elsewhere;
for `softsample.fem.lanes` make and the workflow keep one cache for each state of the sources.
"""

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.functions import log
from softsample.constitutive.law import FibreLaw, InvariantLaw, SpectralLaw
from softsample.constitutive.laws import LAWS
from softsample.fem.lanes import (
    copysign,
    gather,
    like,
    load,
    reciprocal_sqrt,
    scatter_add,
    store,
)

FREE, BASE, PLATEN = 0, 1, 2
"""What holds a node: nothing, the fixed base platen, the moving platen."""

TINY = 1e-18
"""Keeps the angle of a rotation defined where there is nothing to rotate."""

_inline = numba.njit(forceinline=True, error_model="numpy", _nrt=False)
# Without reference counting of arrays (`_nrt`), which halves the speed of these loops.


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


class Solid(NamedTuple):
    """What the elements are made of: terms, those in principal stretches first, fibres last."""

    modulus: NDArray
    """(n_terms,) float64 moduli [Pa]."""
    law: NDArray
    """(n_terms,) int64: number of the law in `NUMBERS`."""
    shape: NDArray
    """(n_terms, n_shape) float64 shape parameters; without eigenvalues Ogden terms are by ascending
    magnitude of their exponents."""
    direction: NDArray
    """(n_terms, 3) float64 unit directions of fibres."""
    first_invariant: int
    """The first term in the invariants of Cbar; those before are in its principal stretches."""
    first_fibre: int
    """The first term of fibres."""
    bulk: float
    """Modulus K [Pa] of the volumetric energy K/2 (J - 1)^2."""
    sweeps: int
    """Zero if the first terms are Ogden terms of even exponents, otherwise how many Jacobi sweeps
    find the eigenvalues."""
    prony: NDArray
    """(n_prony,) float64: relaxing parts g of the isochoric stress, sum below one."""


# --- the laws ------------------------------------------------------------------------------------


@_inline
def _three(x, a):
    """Three numbers in the type of x."""
    return like(x, a[0]), like(x, a[1]), like(x, a[2])


@_inline
def _four(x, a):
    return like(x, a[0]), like(x, a[1]), like(x, a[2]), like(x, a[3])


def _either(number, law, alike, rest):
    """Function of a law's number, strains and shape that calls this law or one of the rest."""
    text = _inline(law)

    @_inline
    def call(chosen, strains, shape):
        if chosen == number:
            return alike(strains[0], text(*strains, shape))
        return rest(chosen, strains, shape)

    return call


def _last(law, alike):
    text = _inline(law)

    @_inline
    def call(chosen, strains, shape):
        return alike(strains[0], text(*strains, shape))

    return call


def _any_of(kind, method, alike):
    """The laws of a kind in one function, a chain of branches that are the same for all lanes.

    Laws in files are known when this module is imported: the compiler sees their texts in place.
    """
    names = [name for name, law in LAWS.items() if isinstance(law, kind)]
    *others, last = (getattr(LAWS[name], method) for name in names)
    call = _last(last, alike)
    for number, law in reversed(list(enumerate(others))):
        call = _either(number, law, alike, call)
    return {name: number for number, name in enumerate(names)}, call


_spectral_numbers, _spectral_law = _any_of(SpectralLaw, "principal", _four)
_invariant_numbers, _invariant_law = _any_of(InvariantLaw, "slopes", _three)
_fibre_numbers, _fibre_law = _any_of(FibreLaw, "slopes", _three)

NUMBERS = {**_spectral_numbers, **_invariant_numbers, **_fibre_numbers}
"""Number of each law among those of its kind."""


# --- one element, or one block of elements ------------------------------------------------------


@_inline
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


@_inline
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


@_inline
def _corners(linear, twisted):
    """Transpose of `_patterns`: eight corners from three linear and four hourglass amplitudes."""
    x, y, z = linear
    yz, zx, xy, xyz = twisted
    high, low = x + xy, x - xy
    s0, s1, s2, s3 = -y - low, low - y, y + high, y - high
    front, back, left, right = z - yz, z + yz, zx - xyz, zx + xyz
    d0, d1, d2, d3 = front - left, front + left, back + right, back - right
    return s0 - d0, s1 - d1, s2 - d2, s3 - d3, s0 + d0, s1 + d1, s2 + d2, s3 + d3


@_inline
def _row3(array, index, lane):
    """Three numbers per lane."""
    return (
        load(array, (index[0], index[1], 0), lane),
        load(array, (index[0], index[1], 1), lane),
        load(array, (index[0], index[1], 2), lane),
    )


@_inline
def _rows3(array, block, lane):
    """Three times three numbers per lane."""
    return (
        _row3(array, (block, 0), lane),
        _row3(array, (block, 1), lane),
        _row3(array, (block, 2), lane),
    )


@_inline
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


@_inline
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


@_inline
def _add_corner(h, x, y, z, b):
    p, q, r = b
    return (
        h[0] + x * p, h[1] + x * q, h[2] + x * r,
        h[3] + y * p, h[4] + y * q, h[5] + y * r,
        h[6] + z * p, h[7] + z * q, h[8] + z * r,
    )  # fmt: skip


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
    """J^(-2/3) by Newton's iteration for J^(-1/3), from a Pade approximant.

    Quadratic and free of branches; to 1e-7 from J = 0.1 to 6, beyond rounding from 0.3 to 3.
    """
    one, third = like(dilatation, 1.0), like(dilatation, 1.0 / 3.0)
    four, J = like(dilatation, 4.0), one + dilatation
    share = third * dilatation
    y = (one + share) / (one + share + share)
    for _ in range(4):
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
def _add_deviator(mandel, factor, a):
    """mandel + factor dev(a) of symmetric matrices."""
    mean = like(factor, 1.0 / 3.0) * (a[0] + a[1] + a[2])
    return (
        mandel[0] + factor * (a[0] - mean),
        mandel[1] + factor * (a[1] - mean),
        mandel[2] + factor * (a[2] - mean),
        mandel[3] + factor * a[3],
        mandel[4] + factor * a[4],
        mandel[5] + factor * a[5],
    )


@_inline
def _by_products(c, solid):
    """Mandel stress and strain energy of Ogden terms of even exponents, from products of Cbar."""
    zero = like(c[0], 0.0)
    mandel, energy = (zero, zero, zero, zero, zero, zero), zero
    base, reached = c, 1
    for k in range(solid.first_invariant):
        alpha, mu = solid.shape[k, 0], solid.modulus[k]
        n = abs(int(alpha)) // 2
        if n % reached:
            base, reached = c, 1
        base = _whole_power(base, n // reached)
        reached = n
        power = _adjugate(base) if alpha < 0.0 else base
        trace = power[0] + power[1] + power[2]
        mandel = _add_deviator(mandel, like(zero, 2.0 * mu / alpha), power)
        energy = energy + like(zero, 2.0 * mu / alpha**2) * (trace - like(zero, 3.0))
    return mandel, energy


@_inline
def _by_eigenvalues(c, jacobian, solid):
    """Mandel stress and strain energy of all terms in the principal stretches, from Cbar."""
    values, vectors = _eigen(c, solid.sweeps)
    half = like(jacobian, 0.5)
    x, y = half * log(values[0]), half * log(values[1])
    z = -x - y  # det Cbar = 1
    energy = first = second = third = like(jacobian, 0.0)
    for k in range(solid.first_invariant):
        w, p, q, r = _spectral_law(solid.law[k], (x, y, z, jacobian), solid.shape[k])
        mu = like(jacobian, solid.modulus[k])
        energy, first, second, third = (
            energy + mu * w, first + mu * p, second + mu * q, third + mu * r
        )  # fmt: skip
    mandel = _sum(_dyad(first, vectors[0]), _dyad(second, vectors[1]))
    return _sum(mandel, _dyad(third, vectors[2])), energy


@_inline
def _add_invariant_laws(mandel, energy, c, solid):
    """Add the terms in the invariants of Cbar: 2 dev(W1 Cbar - W2 Cbar^-1)."""
    inverse = _adjugate(c)
    three = like(energy, 3.0)
    x = c[0] + c[1] + c[2] - three
    y = inverse[0] + inverse[1] + inverse[2] - three
    by_first = by_second = like(energy, 0.0)
    for k in range(solid.first_invariant, solid.first_fibre):
        w, first, second = _invariant_law(solid.law[k], (x, y), solid.shape[k])
        mu = like(energy, solid.modulus[k])
        energy = energy + mu * w
        by_first, by_second = by_first + mu * first, by_second + mu * second
    two = like(energy, 2.0)
    return _add_deviator(mandel, two, _combine(by_first, c, -by_second, inverse)), energy


@_inline
def _isochoric(c, jacobian, solid):
    """Mandel stress and strain energy of all terms but fibres, from Cbar and J."""
    if solid.sweeps > 0:
        mandel, energy = _by_eigenvalues(c, jacobian, solid)
    else:
        mandel, energy = _by_products(c, solid)
    if solid.first_fibre > solid.first_invariant:
        mandel, energy = _add_invariant_laws(mandel, energy, c, solid)
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
def _fibres(c, scale, mandel, energy, solid):
    """Add fibres to Mandel stress and energy, but for their second Piola-Kirchhoff stress along a.

    S = 2 W4 J^(-2/3) (a a - (a . C a) C^-1 / 3), and the stress of W1 as in any law of I1.
    """
    zero, two = like(scale, 0.0), like(scale, 2.0)
    along, total, mean = (zero, zero, zero, zero, zero, zero), zero, zero
    one = like(scale, 1.0)
    x = c[0] + c[1] + c[2] - like(scale, 3.0)
    for k in range(solid.first_fibre, solid.modulus.size):
        direction, mu = solid.direction[k], like(scale, solid.modulus[k])
        a, b, d = like(scale, direction[0]), like(scale, direction[1]), like(scale, direction[2])
        square = c[0] * a * a + c[1] * b * b + c[2] * d * d
        square = square + two * (c[3] * b * d + c[4] * d * a + c[5] * a * b)
        w, first, fourth = _fibre_law(solid.law[k], (x, square - one), solid.shape[k])
        pull = two * mu * fourth
        along = _sum(along, _dyad(pull * scale, (a, b, d)))
        mean = mean - like(scale, 1.0 / 3.0) * pull * square
        total, energy = total + mu * first, energy + mu * w
    mandel = _add_deviator(mandel, two * total, c)
    mandel = (
        mandel[0] + mean, mandel[1] + mean, mandel[2] + mean, mandel[3], mandel[4], mandel[5]
    )  # fmt: skip
    return mandel, energy, along


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
    jacobian = like(scale, 1.0) + dilatation
    mandel, energy = _isochoric(c, jacobian, solid)
    volume = load(elements.volume, (block,), lane)
    if solid.first_fibre < solid.modulus.size:
        mandel, energy, along = _fibres(c, scale, mandel, energy, solid)
        stress = _fall_inverse(cofactor, volume / jacobian, mandel)
        stress = _add_scaled(stress, volume, _push(h, along))
    else:
        stress = _fall_inverse(cofactor, volume / jacobian, mandel)
    if solid.prony.size > 0:
        elastic = _pull_back(cofactor, jacobian, stress)
        stress = _push(h, _relax(elastic, solid.prony, relax, viscous, block, lane))
    pressure = like(scale, solid.bulk) * dilatation
    energy = volume * (energy + like(scale, 0.5) * pressure * dilatation)
    return _add_scaled(stress, volume * pressure, cofactor), energy, dilatation


@_inline
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@_inline
def _without_linear_part(g, h, linear):
    """Amplitudes of four hourglass patterns of one component, less what its gradient h explains."""
    return (
        g[0] - _dot(h, linear[0]), g[1] - _dot(h, linear[1]),
        g[2] - _dot(h, linear[2]), g[3] - _dot(h, linear[3]),
    )  # fmt: skip


@_inline
def _back_on_gradient(p, f, linear):
    """One row of the stress less the outer product of hourglass forces and linear parts."""
    a, b, c, d = linear
    return (
        p[0] - (f[0] * a[0] + f[1] * b[0] + f[2] * c[0] + f[3] * d[0]),
        p[1] - (f[0] * a[1] + f[1] * b[1] + f[2] * c[1] + f[3] * d[1]),
        p[2] - (f[0] * a[2] + f[1] * b[2] + f[2] * c[2] + f[3] * d[2]),
    )


@_inline
def _scaled(k, a):
    return k * a[0], k * a[1], k * a[2], k * a[3]


@_inline
def _squares(a):
    return (a[0] * a[0] + a[1] * a[1]) + (a[2] * a[2] + a[3] * a[3])


@_inline
def _note(state, block, lane, energy, k, gx, gy, gz, dilatation):
    """Strain energy, hourglass energy and J - 1."""
    twist = like(k, 0.5) * k * (_squares(gx) + _squares(gy) + _squares(gz))
    store(state, (0, block), lane, energy)
    store(state, (1, block), lane, twist)
    store(state, (2, block), lane, dilatation)


@_inline
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


@_inline
def _add_linear(x, p, array, block, lane):
    """Add to eight corners the product of a row of the stress and the mean gradients."""
    return (
        x[0] + _dot(p, _row3(array, (block, 0), lane)),
        x[1] + _dot(p, _row3(array, (block, 1), lane)),
        x[2] + _dot(p, _row3(array, (block, 2), lane)),
        x[3] + _dot(p, _row3(array, (block, 3), lane)),
        x[4] + _dot(p, _row3(array, (block, 4), lane)),
        x[5] + _dot(p, _row3(array, (block, 5), lane)),
        x[6] + _dot(p, _row3(array, (block, 6), lane)),
        x[7] + _dot(p, _row3(array, (block, 7), lane)),
    )


@_inline
def _regular_element(u, elements, solid, relax, viscous, force, state, watch, block, lane):
    """Add the forces of a parallelepiped, or of a block of them, and note their state."""
    x, y, z = _gather8(u, elements, block, lane)
    (x, gx), (y, gy), (z, gz) = _patterns(x), _patterns(y), _patterns(z)
    slopes = _rows3(elements.slopes, block, lane)
    h = _outer_sum(x, y, z, slopes)
    p, energy, dilatation = _stress(h, elements, solid, relax, viscous, block, lane)
    k = load(elements.stiffness, (block,), lane)
    if watch:
        _note(state, block, lane, energy, k, gx, gy, gz, dilatation)
    a, b, c = slopes
    px, py, pz = (p[0], p[1], p[2]), (p[3], p[4], p[5]), (p[6], p[7], p[8])
    _scatter8(
        force, elements, block, lane,
        _corners((_dot(px, a), _dot(px, b), _dot(px, c)), _scaled(k, gx)),
        _corners((_dot(py, a), _dot(py, b), _dot(py, c)), _scaled(k, gy)),
        _corners((_dot(pz, a), _dot(pz, b), _dot(pz, c)), _scaled(k, gz)),
    )  # fmt: skip


@_inline
def _element(u, elements, solid, relax, viscous, force, state, watch, block, lane):
    """Add the forces of any element, or of a block of them, and note their state."""
    place = block - elements.slopes.shape[0]
    x, y, z = _gather8(u, elements, block, lane)
    gx, gy, gz = _patterns(x)[1], _patterns(y)[1], _patterns(z)[1]
    h = _gradient(x, y, z, elements.gradient, place, lane)
    p, energy, dilatation = _stress(h, elements, solid, relax, viscous, block, lane)
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


@numba.njit(cache=True, error_model="numpy", _nrt=False)
def _add_forces(u, elements, solid, relax, viscous, force, state, watch, lane):
    """Add the forces of all elements; see `internal_force`."""
    regular = elements.slopes.shape[0]
    for block in range(elements.connectivity.shape[0]):
        if lane is None:
            if block < regular:
                _regular_element(
                    u, elements, solid, relax, viscous, force, state, watch, block, None
                )
            else:
                _element(u, elements, solid, relax, viscous, force, state, watch, block, None)
        else:
            for k in range(elements.connectivity.shape[2]):
                if block < regular:
                    _regular_element(
                        u, elements, solid, relax, viscous, force, state, watch, block, k
                    )
                else:
                    _element(u, elements, solid, relax, viscous, force, state, watch, block, k)


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
    _add_forces(u, elements, solid, relax, viscous, force, state, watch, lane)


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
    u, force = motion.u, motion.force
    steps = path.size - 1
    force[:] = 0.0
    for step in range(steps):
        last = step == steps - 1
        _add_forces(
            u, elements, solid, relax[step], motion.viscous, force, motion.state, last, lane
        )
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
def _move(registers, kick, dt, last, lane):
    """Kick and drift all nodes and clear the forces; held ones keep the velocity set for them."""
    for row in range(registers[0].shape[0]):
        if lane is None:
            _move_row(registers, kick, dt, last, row, None)
        else:
            for k in range(registers[0].shape[1]):
                _move_row(registers, kick, dt, last, row, k)


@_inline
def _move_row(registers, kick, dt, last, row, lane):
    u, v, force, mobility = registers
    f = load(force, (row,), lane)
    speed = load(v, (row,), lane) - like(f, kick) * load(mobility, (row,), lane) * f
    store(v, (row,), lane, speed)
    store(u, (row,), lane, load(u, (row,), lane) + like(f, dt) * speed)
    if not last:
        store(force, (row,), lane, like(f, 0.0))


@_inline
def _times(k, a):
    return k * a[0], k * a[1], k * a[2]


@_inline
def _each(a, b):
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


@_inline
def _reaction(node, rate, velocity, motion):
    """Force of the platen on a held node [N]: its force plus mass times acceleration."""
    inertia, force, v = motion.mass[node] * rate, motion.force, motion.v
    return (
        force[node, 0] + inertia * (velocity[0] - v[node, 0]),
        force[node, 1] + inertia * (velocity[1] - v[node, 1]),
        force[node, 2] + inertia * (velocity[2] - v[node, 2]),
    )


@_inline
def _add3(row, first, k, b):
    """Add to three numbers of a row k times three others."""
    row[first] += k * b[0]
    row[first + 1] += k * b[1]
    row[first + 2] += k * b[2]


@_inline
def _column(holder):
    """First column of `history` for the forces of a platen."""
    return 0 if holder == PLATEN else 3


@_inline
def _carry(nodes, rate, velocity, motion, mobile, record, holder):
    """Give glued nodes their platen's velocity and record the force that this takes."""
    x = y = z = 0.0
    for node in nodes:
        a, b, c = _reaction(node, rate, velocity, motion)
        x, y, z = x + a, y + b, z + c
        motion.v[node, 0], motion.v[node, 1], motion.v[node, 2] = velocity
    _add3(record, _column(holder), 1.0, _each((x, y, z), mobile))


@_inline
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


@_inline
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
        distance = np.sqrt(_dot(way, way))
        return _times(1.0 / distance, way), platens.ball[3] - distance
    n = platens.planes[holder - 1]
    gap = -n[3] - travel * _dot(n, platens.direction)
    for i in range(3):
        gap += x[i] * n[i]
    return (n[0], n[1], n[2]), gap


@_inline
def _press(node, kick, travel, speed, dt, motion, platens, record):
    """Hold a touching node as long as its platen pushes, with no more than friction sideways."""
    holder = motion.held[node]
    n, gap = _contact(node, holder, travel, motion, platens)
    velocity = _times(speed if holder == PLATEN else 0.0, platens.direction)
    push = _each(_reaction(node, 1.0 / kick, velocity, motion), platens.mobile)
    pull = _dot(push, n)
    if platens.release and pull > 0.0:
        motion.held[node] = FREE
        for i in range(3):
            motion.mobility[node, i] = platens.mobile[i] / motion.mass[node]
        return
    motion.v[node, 0], motion.v[node, 1], motion.v[node, 2] = velocity
    _add3(record, _column(holder), 1.0, push)
    if platens.friction[holder - 1] < np.inf:
        sideways = push[0] - pull * n[0], push[1] - pull * n[1], push[2] - pull * n[2]
        size = np.sqrt(_dot(sideways, sideways))
        limit = platens.friction[holder - 1] * max(-pull, 0.0)
        if size > limit:
            excess = 1.0 - limit / size
            mobility = excess * kick / motion.mass[node]
            _add3(record, _column(holder), -excess, sideways)
            _add3(motion.v[node], 0, -mobility, sideways)
            record[6] -= limit * mobility * size * dt
        if holder == PLATEN and platens.ball[3] > 0.0:  # back from the tangent onto the ball
            _add3(motion.v[node], 0, -gap / dt, n)


@_inline
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
