"""Compiled kernels of the explicit solver; arguments are checked by `softsample.fem.explicit`.

Elements are processed in blocks of `LANES`, one element per vector lane: each small function
below loops over the lanes of rows such as `c[k, lane]`, which the compiler turns into vector code.
`tests/naive.py` says the same, one element at a time. All kernels live in this file because a
cached kernel does not notice an edit of a callee in another file.
"""

import numba
import numpy as np

LANES = 16
"""Elements per block: one AVX-512 register of float32."""

FREE, BASE, PLATEN = 0, 1, 2
"""What holds a node: nothing, the fixed base platen, the moving platen."""

_inline = numba.njit(cache=True, forceinline=True, error_model="numpy")


@_inline
def _hadamard(u, i):
    """Walsh-Hadamard transform over the 8 corners of component i: sums along all patterns."""
    for lane in range(LANES):
        a0, a1, a2, a3 = u[0, i, lane], u[1, i, lane], u[2, i, lane], u[3, i, lane]
        a4, a5, a6, a7 = u[4, i, lane], u[5, i, lane], u[6, i, lane], u[7, i, lane]
        s0, s1, s2, s3 = a0 + a4, a1 + a5, a2 + a6, a3 + a7
        d0, d1, d2, d3 = a4 - a0, a5 - a1, a6 - a2, a7 - a3
        u[8, i, lane] = (d2 + d3) - (d0 + d1)
        u[9, i, lane] = (d1 + d2) - (d0 + d3)
        u[10, i, lane] = (s0 + s2) - (s1 + s3)
        u[11, i, lane] = (d0 + d2) - (d1 + d3)


@_inline
def _displacement_gradient(u, B, block, h, i, j):
    """h[i, j] = du_i / dX_j of the uniform strain element."""
    for lane in range(LANES):
        h[i, j, lane] = (
            (u[0, i, lane] * B[block, 0, j, lane] + u[1, i, lane] * B[block, 1, j, lane])
            + (u[2, i, lane] * B[block, 2, j, lane] + u[3, i, lane] * B[block, 3, j, lane])
        ) + (
            (u[4, i, lane] * B[block, 4, j, lane] + u[5, i, lane] * B[block, 5, j, lane])
            + (u[6, i, lane] * B[block, 6, j, lane] + u[7, i, lane] * B[block, 7, j, lane])
        )


@_inline
def _isochoric_cauchy_green(h, c, cofactor, jacobian):
    """Cbar = J^(-2/3) F^T F (rows xx, yy, zz, yz, zx, xy), cof F and J - 1 from h = F - I.

    C - I and J - 1 are formed from h, so that small strains keep their digits in float32. The
    cube root is Newton's iteration for y = J^(-1/3), quadratic and free of branches.
    """
    one = h.dtype.type(1)
    third = h.dtype.type(1.0 / 3.0)
    four = h.dtype.type(4)
    for lane in range(LANES):
        a, b, d = h[0, 0, lane], h[0, 1, lane], h[0, 2, lane]
        e, f, g = h[1, 0, lane], h[1, 1, lane], h[1, 2, lane]
        p, q, r = h[2, 0, lane], h[2, 1, lane], h[2, 2, lane]
        cofactor[0, 0, lane] = (one + f) * (one + r) - g * q
        cofactor[0, 1, lane] = g * p - e * (one + r)
        cofactor[0, 2, lane] = e * q - (one + f) * p
        cofactor[1, 0, lane] = d * q - b * (one + r)
        cofactor[1, 1, lane] = (one + a) * (one + r) - d * p
        cofactor[1, 2, lane] = b * p - (one + a) * q
        cofactor[2, 0, lane] = b * g - d * (one + f)
        cofactor[2, 1, lane] = d * e - (one + a) * g
        cofactor[2, 2, lane] = (one + a) * (one + f) - b * e
        minors = (f * r - g * q) + (a * r - d * p) + (a * f - b * e)
        cubic = a * (f * r - g * q) - b * (e * r - g * p) + d * (e * q - f * p)
        dilatation = (a + f + r) + minors + cubic
        jacobian[lane] = dilatation
        J = one + dilatation
        y = one - third * dilatation
        y = y if y > third else third
        for _ in range(5):
            y = y * (four - J * y * y * y) * third
        y = y * y
        c[0, lane] = y * (one + (a + a + a * a + e * e + p * p))
        c[1, lane] = y * (one + (f + f + b * b + f * f + q * q))
        c[2, lane] = y * (one + (r + r + d * d + g * g + r * r))
        c[3, lane] = y * (g + q + b * d + f * g + q * r)
        c[4, lane] = y * (d + p + d * a + g * e + r * p)
        c[5, lane] = y * (b + e + a * b + e * f + p * q)


@_inline
def _product(a, b, out):
    """out = a b of symmetric matrices that commute; out may be a or b."""
    for lane in range(LANES):
        xx, yy, zz, yz, zx, xy = (
            a[0, lane], a[1, lane], a[2, lane], a[3, lane], a[4, lane], a[5, lane]
        )  # fmt: skip
        XX, YY, ZZ, YZ, ZX, XY = (
            b[0, lane], b[1, lane], b[2, lane], b[3, lane], b[4, lane], b[5, lane]
        )  # fmt: skip
        out[0, lane] = xx * XX + xy * XY + zx * ZX
        out[1, lane] = xy * XY + yy * YY + yz * YZ
        out[2, lane] = zx * ZX + yz * YZ + zz * ZZ
        out[3, lane] = xy * ZX + yy * YZ + yz * ZZ
        out[4, lane] = zx * XX + yz * XY + zz * ZX
        out[5, lane] = xx * XY + xy * YY + zx * YZ


@_inline
def _adjugate(a, out):
    """out = adj(a), the inverse of a symmetric matrix of determinant one; out may be a."""
    for lane in range(LANES):
        xx, yy, zz, yz, zx, xy = (
            a[0, lane], a[1, lane], a[2, lane], a[3, lane], a[4, lane], a[5, lane]
        )  # fmt: skip
        out[0, lane] = yy * zz - yz * yz
        out[1, lane] = zz * xx - zx * zx
        out[2, lane] = xx * yy - xy * xy
        out[3, lane] = zx * xy - xx * yz
        out[4, lane] = xy * yz - yy * zx
        out[5, lane] = yz * zx - zz * xy


@_inline
def _integer_power(c, exponent, square, out):
    """out = c^exponent by repeated squaring; a negative power inverts last (det c = 1)."""
    remaining = abs(exponent)
    started = False
    for k in range(6):
        for lane in range(LANES):
            square[k, lane] = c[k, lane]
    while remaining > 0:
        if remaining & 1:
            if started:
                _product(out, square, out)
            else:
                started = True
                for k in range(6):
                    for lane in range(LANES):
                        out[k, lane] = square[k, lane]
        remaining >>= 1
        if remaining > 0:
            _product(square, square, square)
    if exponent < 0:
        _adjugate(out, out)


@_inline
def _rotate(matrix, vectors, p, q):
    """One Jacobi rotation that annuls matrix[p, q] of a symmetric 3x3 matrix."""
    off = matrix[p, q]
    if off == 0.0:
        return
    theta = (matrix[q, q] - matrix[p, p]) / (2.0 * off)
    t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
    t = -t if theta < 0.0 else t
    cosine = 1.0 / np.sqrt(t * t + 1.0)
    sine = t * cosine
    for k in range(3):
        a, b = matrix[k, p], matrix[k, q]
        matrix[k, p], matrix[k, q] = cosine * a - sine * b, sine * a + cosine * b
    for k in range(3):
        a, b = matrix[p, k], matrix[q, k]
        matrix[p, k], matrix[q, k] = cosine * a - sine * b, sine * a + cosine * b
    for k in range(3):
        a, b = vectors[k, p], vectors[k, q]
        vectors[k, p], vectors[k, q] = cosine * a - sine * b, sine * a + cosine * b


@numba.njit(cache=True, error_model="numpy")
def _spectral(c, vectors, squared):
    """Eigenvalues `squared` (3, LANES) and eigenvectors (3, 3, LANES) of c by cyclic Jacobi."""
    matrix = np.empty((3, 3))
    basis = np.empty((3, 3))
    for lane in range(LANES):
        matrix[0, 0], matrix[1, 1], matrix[2, 2] = c[0, lane], c[1, lane], c[2, lane]
        matrix[1, 2] = matrix[2, 1] = c[3, lane]
        matrix[2, 0] = matrix[0, 2] = c[4, lane]
        matrix[0, 1] = matrix[1, 0] = c[5, lane]
        basis[:] = 0.0
        basis[0, 0] = basis[1, 1] = basis[2, 2] = 1.0
        for _ in range(12):
            off = matrix[0, 1] ** 2 + matrix[1, 2] ** 2 + matrix[2, 0] ** 2
            if off < 1e-30:
                break
            _rotate(matrix, basis, 0, 1)
            _rotate(matrix, basis, 1, 2)
            _rotate(matrix, basis, 0, 2)
        for a in range(3):
            squared[a, lane] = matrix[a, a]
            for i in range(3):
                vectors[i, a, lane] = basis[i, a]


@_inline
def _real_power(vectors, squared, exponent, out):
    """out = sum_a squared_a^exponent n_a n_a for any real exponent."""
    for lane in range(LANES):
        for k in range(6):
            out[k, lane] = 0.0
        for a in range(3):
            w = squared[a, lane] ** exponent
            x, y, z = vectors[0, a, lane], vectors[1, a, lane], vectors[2, a, lane]
            out[0, lane] += w * x * x
            out[1, lane] += w * y * y
            out[2, lane] += w * z * z
            out[3, lane] += w * y * z
            out[4, lane] += w * z * x
            out[5, lane] += w * x * y


@_inline
def _add_term(power, coefficient, weight, mandel, energy):
    """Add one Ogden term to the Mandel stress and the strain energy."""
    third = power.dtype.type(1.0 / 3.0)
    three = power.dtype.type(3)
    for lane in range(LANES):
        trace = power[0, lane] + power[1, lane] + power[2, lane]
        mandel[0, lane] += coefficient * (power[0, lane] - third * trace)
        mandel[1, lane] += coefficient * (power[1, lane] - third * trace)
        mandel[2, lane] += coefficient * (power[2, lane] - third * trace)
        mandel[3, lane] += coefficient * power[3, lane]
        mandel[4, lane] += coefficient * power[4, lane]
        mandel[5, lane] += coefficient * power[5, lane]
        energy[lane] += weight * (trace - three)


@_inline
def _start_volumetric(jacobian, bulk, mandel, energy):
    """Mandel stress K (J - 1) J I and energy K/2 (J - 1)^2 of U(J); clears the rest."""
    half = jacobian.dtype.type(0.5)
    one = jacobian.dtype.type(1)
    zero = jacobian.dtype.type(0)
    for lane in range(LANES):
        dilatation = jacobian[lane]
        pressure = bulk * dilatation * (one + dilatation)
        mandel[0, lane], mandel[1, lane], mandel[2, lane] = pressure, pressure, pressure
        mandel[3, lane], mandel[4, lane], mandel[5, lane] = zero, zero, zero
        energy[lane] = half * bulk * dilatation * dilatation


@_inline
def _nominal_stress(cofactor, jacobian, volume, block, mandel, stress):
    """stress = V F^-T M, reusing cof F = J F^-T."""
    one = jacobian.dtype.type(1)
    for i in range(3):
        for lane in range(LANES):
            scale = volume[block, lane] / (one + jacobian[lane])
            x = scale * cofactor[i, 0, lane]
            y = scale * cofactor[i, 1, lane]
            z = scale * cofactor[i, 2, lane]
            stress[i, 0, lane] = x * mandel[0, lane] + y * mandel[5, lane] + z * mandel[4, lane]
            stress[i, 1, lane] = x * mandel[5, lane] + y * mandel[1, lane] + z * mandel[3, lane]
            stress[i, 2, lane] = x * mandel[4, lane] + y * mandel[3, lane] + z * mandel[2, lane]


@_inline
def _hourglass(u, h, H, stiffness, block, i, stress, energy):
    """Replace the pattern sums u[8:12] by hourglass forces; take their linear part off `stress`."""
    half = energy.dtype.type(0.5)
    for m in range(4):
        for lane in range(LANES):
            linear = (
                h[i, 0, lane] * H[block, m, 0, lane]
                + h[i, 1, lane] * H[block, m, 1, lane]
                + h[i, 2, lane] * H[block, m, 2, lane]
            )
            amplitude = u[8 + m, i, lane] - linear
            force = stiffness[block, lane] * amplitude
            u[8 + m, i, lane] = force
            energy[lane] += half * force * amplitude
            stress[i, 0, lane] -= force * H[block, m, 0, lane]
            stress[i, 1, lane] -= force * H[block, m, 1, lane]
            stress[i, 2, lane] -= force * H[block, m, 2, lane]


@_inline
def _corner_forces(u, B, block, stress, i):
    """u[a, i] = stress . B_a plus the hourglass patterns (transpose of `_hadamard`)."""
    for lane in range(LANES):
        x, y, z = stress[i, 0, lane], stress[i, 1, lane], stress[i, 2, lane]
        g0, g1, g2, g3 = u[8, i, lane], u[9, i, lane], u[10, i, lane], u[11, i, lane]
        p, q, r, s = g0 + g1, g0 - g1, g2 + g3, g2 - g3
        for a in range(8):
            u[a, i, lane] = (
                x * B[block, a, 0, lane] + y * B[block, a, 1, lane] + z * B[block, a, 2, lane]
            )
        u[0, i, lane] += p + s
        u[1, i, lane] += q - s
        u[2, i, lane] += s - p
        u[3, i, lane] -= q + s
        u[4, i, lane] += r - p
        u[5, i, lane] -= q + r
        u[6, i, lane] += p + r
        u[7, i, lane] += q - r


@numba.njit(cache=True, error_model="numpy")
def internal_force(u, elements, material, force, state):
    """Sum of all element forces; returns nothing.

    Parameters
    ----------
    u : (n_nodes, 3) float32 or float64
        Displacements [m].
    elements : tuple
        `connectivity` (n_blocks, 8, LANES) int32, `B` (n_blocks, 8, 3, LANES),
        `H` (n_blocks, 4, 3, LANES), `volume` and hourglass `stiffness` (n_blocks, LANES), number
        of elements. Lanes beyond it repeat the last element and are not scattered.
    material : tuple
        `mu`, `alpha` (n_terms,) float64, bulk modulus [Pa], whether to take the spectral path.
    force : (n_nodes, 3), same dtype
        Internal nodal forces [N], overwritten: the resistance of the elements to `u`.
    state : (3, n_blocks, LANES), same dtype
        Strain energy [J], hourglass energy [J] and J - 1 of each element, overwritten.
    """
    connectivity, B, H, volume, stiffness, n_elements = elements
    mu, alpha, bulk_modulus, spectral = material
    real = u.dtype.type
    bulk = real(bulk_modulus)
    x = np.empty((12, 3, LANES), u.dtype)
    h = np.empty((3, 3, LANES), u.dtype)
    cofactor = np.empty((3, 3, LANES), u.dtype)
    stress = np.empty((3, 3, LANES), u.dtype)
    c = np.empty((6, LANES), u.dtype)
    square = np.empty((6, LANES), u.dtype)
    power = np.empty((6, LANES), u.dtype)
    mandel = np.empty((6, LANES), u.dtype)
    jacobian = np.empty(LANES, u.dtype)
    energy = np.empty(LANES, u.dtype)
    vectors = np.empty((3, 3, LANES))
    squared = np.empty((3, LANES))
    force[:] = real(0)
    for block in range(connectivity.shape[0]):
        for a in range(8):
            for lane in range(LANES):
                node = connectivity[block, a, lane]
                x[a, 0, lane] = u[node, 0]
                x[a, 1, lane] = u[node, 1]
                x[a, 2, lane] = u[node, 2]
        for i in range(3):
            _hadamard(x, i)
            for j in range(3):
                _displacement_gradient(x, B, block, h, i, j)
        _isochoric_cauchy_green(h, c, cofactor, jacobian)
        _start_volumetric(jacobian, bulk, mandel, energy)
        if spectral:
            _spectral(c, vectors, squared)
        for term in range(mu.size):
            if spectral:
                _real_power(vectors, squared, 0.5 * alpha[term], power)
            else:
                _integer_power(c, int(alpha[term]) // 2, square, power)
            _add_term(
                power,
                real(2.0 * mu[term] / alpha[term]),
                real(2.0 * mu[term] / alpha[term] ** 2),
                mandel,
                energy,
            )
        _nominal_stress(cofactor, jacobian, volume, block, mandel, stress)
        for lane in range(LANES):
            state[0, block, lane] = energy[lane] * volume[block, lane]
            state[2, block, lane] = jacobian[lane]
            energy[lane] = real(0)
        for i in range(3):
            _hourglass(x, h, H, stiffness, block, i, stress, energy)
            _corner_forces(x, B, block, stress, i)
        for lane in range(LANES):
            state[1, block, lane] = energy[lane]
        for lane in range(min(LANES, n_elements - block * LANES)):
            for a in range(8):
                node = connectivity[block, a, lane]
                force[node, 0] += x[a, 0, lane]
                force[node, 1] += x[a, 1, lane]
                force[node, 2] += x[a, 2, lane]


@numba.njit(cache=True, error_model="numpy")
def advance(path, dt, dt_before, u, v, force, state, elements, material, mass, mobility, points,
            held, watched, planes, direction, release, history):  # fmt: skip
    """March the central difference scheme over ``len(path) - 1`` equal steps.

    Parameters
    ----------
    path : (n_steps + 1,) float64
        Travel of the moving platen [m] along `direction` at the start of each step and at the end.
    dt, dt_before : float
        This slice's time step and that of the step before it [s].
    mass : (n_nodes,) float64
        Lumped masses [kg].
    mobility : (n_nodes, 3), dtype of the state
        Inverse mass of free nodes [1/kg], zero for held ones; kept in step with `held`.
    held : (n_nodes,) int8
        FREE, BASE or PLATEN for every node; contact changes it.
    watched : tuple of (n,) int32
        Nodes held for good, and nodes that may touch a platen.
    planes : (2, 4) float64
        Base and moving platen at zero travel: outward unit normal (from the sample into the
        platen) and offset [m]; an infinite offset switches a platen's contact off.
    direction : (3,) float64
        Unit vector of the platen's travel.
    release : bool
        Whether a touching node lets go of a platen that would have to pull on it.
    history : (n_steps, 7) float64
        Per step: travel at its start [m], force of the moving platen and of the base on the
        sample [N]; overwritten.
    """
    glued, candidates = watched
    plane = planes.copy()
    approach = 0.0
    for i in range(3):
        approach += planes[PLATEN - 1, i] * direction[i]
    for step in range(path.size - 1):
        internal_force(u, elements, material, force, state)
        kick = 0.5 * (dt + dt_before)
        speed = (path[step + 1] - path[step]) / dt
        plane[PLATEN - 1, 3] = planes[PLATEN - 1, 3] + path[step + 1] * approach
        record = history[step]
        record[:] = 0.0
        record[0] = path[step]
        for node in glued:
            _hold(node, kick, speed, v, force, mass, held, direction, record)
        for node in candidates:
            if held[node] != FREE:
                if release and _pull(node, kick, speed, v, force, mass, held, plane, direction) > 0:
                    held[node] = FREE
                    mobility[node, :] = 1.0 / mass[node]
                else:
                    _hold(node, kick, speed, v, force, mass, held, direction, record)
        _move(u, v, force, mobility, u.dtype.type(kick), u.dtype.type(dt))
        for node in candidates:
            if held[node] == FREE:
                _catch(node, dt, kick, u, v, mass, mobility, points, held, plane, record)
        dt_before = dt


@_inline
def _move(u, v, force, mobility, kick, dt):
    """Kick and drift all nodes; held ones keep the velocity that was set for them."""
    for node in range(u.shape[0]):
        for i in range(3):
            v[node, i] -= kick * mobility[node, i] * force[node, i]
            u[node, i] += dt * v[node, i]


@_inline
def _reaction(node, i, kick, speed, v, force, mass, held, direction):
    """Force of the platen on a held node [N]: internal force plus mass times acceleration."""
    new = speed * direction[i] if held[node] == PLATEN else 0.0
    return force[node, i] + mass[node] * (new - v[node, i]) / kick


@_inline
def _hold(node, kick, speed, v, force, mass, held, direction, record):
    """Give a held node its platen's velocity and record the force that this takes."""
    column = 1 if held[node] == PLATEN else 4
    for i in range(3):
        record[column + i] += _reaction(node, i, kick, speed, v, force, mass, held, direction)
        v[node, i] = speed * direction[i] if held[node] == PLATEN else 0.0


@_inline
def _pull(node, kick, speed, v, force, mass, held, plane, direction):
    """Normal force with which its platen pulls on a held node [N]."""
    pull = 0.0
    for i in range(3):
        reaction = _reaction(node, i, kick, speed, v, force, mass, held, direction)
        pull += reaction * plane[held[node] - 1, i]
    return pull


@_inline
def _catch(node, dt, kick, u, v, mass, mobility, points, held, plane, record):
    """Stop a free node at the platen it has just passed; it sticks there (no slip)."""
    for holder in (BASE, PLATEN):
        gap = -plane[holder - 1, 3]
        for i in range(3):
            gap += (points[node, i] + u[node, i]) * plane[holder - 1, i]
        if gap > 0.0:
            held[node] = holder
            for i in range(3):
                back = gap * plane[holder - 1, i]
                u[node, i] -= back
                v[node, i] -= back / dt
                mobility[node, i] = 0.0
                record[(1 if holder == PLATEN else 4) + i] -= mass[node] * back / dt / kick
            return
