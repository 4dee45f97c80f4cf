"""Stress and strain energy of one element, or of a block of them, compiled."""

from typing import NamedTuple

from numpy.typing import NDArray

from softsample.constitutive.functions import log
from softsample.constitutive.law import FibreLaw, InvariantLaw, SpectralLaw
from softsample.constitutive.laws import LAWS
from softsample.fem.lanes import inline, like, load, store
from softsample.fem.tensors import (
    add_deviator,
    add_scaled,
    added,
    adjugate,
    cauchy_green,
    cofactor_product,
    cofactors,
    combined,
    dyad,
    eigen,
    inverse_square_cube_root,
    pull_back,
    push,
    whole_power,
)


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


@inline
def _three(x, a):
    """Three numbers in the type of x."""
    return like(x, a[0]), like(x, a[1]), like(x, a[2])


@inline
def _four(x, a):
    return like(x, a[0]), like(x, a[1]), like(x, a[2]), like(x, a[3])


def _either(number, law, alike, rest):
    """Function of a law's number, strains and shape that calls this law or one of the rest."""
    text = inline(law)

    @inline
    def call(chosen, strains, shape):
        if chosen == number:
            return alike(strains[0], text(*strains, shape))
        return rest(chosen, strains, shape)

    return call


def _last(law, alike):
    text = inline(law)

    @inline
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


@inline
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
        base = whole_power(base, n // reached)
        reached = n
        power = adjugate(base) if alpha < 0.0 else base
        trace = power[0] + power[1] + power[2]
        mandel = add_deviator(mandel, like(zero, 2.0 * mu / alpha), power)
        energy = energy + like(zero, 2.0 * mu / alpha**2) * (trace - like(zero, 3.0))
    return mandel, energy


@inline
def _by_eigenvalues(c, jacobian, solid):
    """Mandel stress and strain energy of all terms in the principal stretches, from Cbar."""
    values, vectors = eigen(c, solid.sweeps)
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
    mandel = added(dyad(first, vectors[0]), dyad(second, vectors[1]))
    return added(mandel, dyad(third, vectors[2])), energy


@inline
def _add_invariant_laws(mandel, energy, c, solid):
    """Add the terms in the invariants of Cbar: 2 dev(W1 Cbar - W2 Cbar^-1)."""
    inverse = adjugate(c)
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
    return add_deviator(mandel, two, combined(by_first, c, -by_second, inverse)), energy


@inline
def _isochoric(c, jacobian, solid):
    """Mandel stress and strain energy of all terms but fibres, from Cbar and J."""
    if solid.sweeps > 0:
        mandel, energy = _by_eigenvalues(c, jacobian, solid)
    else:
        mandel, energy = _by_products(c, solid)
    if solid.first_fibre > solid.first_invariant:
        mandel, energy = _add_invariant_laws(mandel, energy, c, solid)
    return mandel, energy


@inline
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
        along = added(along, dyad(pull * scale, (a, b, d)))
        mean = mean - like(scale, 1.0 / 3.0) * pull * square
        total, energy = total + mu * first, energy + mu * w
    mandel = add_deviator(mandel, two * total, c)
    mandel = (
        mandel[0] + mean, mandel[1] + mean, mandel[2] + mean, mandel[3], mandel[4], mandel[5]
    )  # fmt: skip
    return mandel, energy, along


@inline
def _load6(array, index, lane):
    return (
        load(array, (index[0], index[1], 0), lane), load(array, (index[0], index[1], 1), lane),
        load(array, (index[0], index[1], 2), lane), load(array, (index[0], index[1], 3), lane),
        load(array, (index[0], index[1], 4), lane), load(array, (index[0], index[1], 5), lane),
    )  # fmt: skip


@inline
def _store6(array, index, lane, a):
    store(array, (index[0], index[1], 0), lane, a[0])
    store(array, (index[0], index[1], 1), lane, a[1])
    store(array, (index[0], index[1], 2), lane, a[2])
    store(array, (index[0], index[1], 3), lane, a[3])
    store(array, (index[0], index[1], 4), lane, a[4])
    store(array, (index[0], index[1], 5), lane, a[5])


@inline
def _relax(elastic, prony, relax, viscous, block, lane):
    """Relaxed second Piola-Kirchhoff stress; brings the history of every Prony term up to date.

    H <- exp(-dt/tau) H + g tau/dt (1 - exp(-dt/tau)) (S - S before): exact for S linear in time.
    """
    one = like(elastic[0], 1.0)
    before = _load6(viscous, (block, 0), lane)
    _store6(viscous, (block, 0), lane, elastic)
    growth = combined(one, elastic, like(one, -1.0), before)
    lasting = 1.0
    for n in range(prony.size):
        lasting -= prony[n]
    total = combined(like(one, lasting), elastic, like(one, 0.0), elastic)
    for n in range(prony.size):
        history = _load6(viscous, (block, n + 1), lane)
        history = combined(like(one, relax[0, n]), history, like(one, relax[1, n]), growth)
        _store6(viscous, (block, n + 1), lane, history)
        total = combined(one, total, one, history)
    return total


@inline
def stress_of(h, elements, solid, relax, viscous, block, lane):
    """Volume times nominal stress (9), volume times strain energy density, and J - 1."""
    cofactor, dilatation = cofactors(h)
    scale = inverse_square_cube_root(dilatation)
    c = cauchy_green(h, scale)
    jacobian = like(scale, 1.0) + dilatation
    mandel, energy = _isochoric(c, jacobian, solid)
    volume = load(elements.volume, (block,), lane)
    if solid.first_fibre < solid.modulus.size:
        mandel, energy, along = _fibres(c, scale, mandel, energy, solid)
        stress = cofactor_product(cofactor, volume / jacobian, mandel)
        stress = add_scaled(stress, volume, push(h, along))
    else:
        stress = cofactor_product(cofactor, volume / jacobian, mandel)
    if solid.prony.size > 0:
        elastic = pull_back(cofactor, jacobian, stress)
        stress = push(h, _relax(elastic, solid.prony, relax, viscous, block, lane))
    pressure = like(scale, solid.bulk) * dilatation
    energy = volume * (energy + like(scale, 0.5) * pressure * dilatation)
    return add_scaled(stress, volume * pressure, cofactor), energy, dilatation
