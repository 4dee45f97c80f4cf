"""Small matrices in compiled kernels: tuples of numbers, or of one number per vector lane.

Nine numbers are a matrix row by row, six a symmetric one: xx, yy, zz, yz, zx, xy.
"""

from softsample.fem.lanes import copysign, inline, like, reciprocal_sqrt

TINY = 1e-18
"""Keeps the angle of a rotation defined where there is nothing to rotate."""


@inline
def dot(a, b):
    """a . b of vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inline
def cofactors(h):
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


@inline
def inverse_square_cube_root(dilatation):
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


@inline
def cauchy_green(h, scale):
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


@inline
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


@inline
def adjugate(a):
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


@inline
def whole_power(a, n):
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


@inline
def _rotation(p, q, off):
    """Cosine, sine and tangent of the Jacobi rotation, at most 45 degrees, that annuls `off`."""
    half, difference = like(off, 0.5), q - p
    gap = copysign(difference, half) + like(off, TINY)
    r = reciprocal_sqrt(gap * gap + like(off, 4.0) * off * off)
    square = half + half * gap * r
    root = reciprocal_sqrt(square)
    sine = copysign(off * r * root, difference * off)
    return square * root, sine, sine * root


@inline
def _rotate(c, s, x, y):
    return c * x - s * y, s * x + c * y


@inline
def eigen(a, sweeps):
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


@inline
def dyad(w, n):
    """w n n, symmetric."""
    x, y, z = n
    wx, wy, wz = w * x, w * y, w * z
    return (wx * x, wy * y, wz * z, wy * z, wz * x, wx * y)


@inline
def added(a, b):
    """a + b of symmetric matrices."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]


@inline
def add_deviator(mandel, factor, a):
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


@inline
def pull_back(cofactor, jacobian, stress):
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


@inline
def push(h, s):
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


@inline
def combined(x, a, y, b):
    """x a + y b of symmetric matrices."""
    return (
        x * a[0] + y * b[0], x * a[1] + y * b[1], x * a[2] + y * b[2],
        x * a[3] + y * b[3], x * a[4] + y * b[4], x * a[5] + y * b[5],
    )  # fmt: skip


@inline
def add_scaled(a, x, b):
    """a + x b of matrices (9, row by row)."""
    return (
        a[0] + x * b[0], a[1] + x * b[1], a[2] + x * b[2],
        a[3] + x * b[3], a[4] + x * b[4], a[5] + x * b[5],
        a[6] + x * b[6], a[7] + x * b[7], a[8] + x * b[8],
    )  # fmt: skip


@inline
def cofactor_product(cofactor, scale, mandel):
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
