"""What goes wrong in the laboratory: one maker for each effect, and for kinds that have no name.

Formulas are the laboratory's own. Travel is positive while loading; forces of the instrument have
the machine's signs and are turned by `Trial.sign`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.signal import fftconvolve
from scipy.special import erf

from softsample.arrays import Array, Mask
from softsample.blindlab.bodies import MODES, PRESSED, Body

Random = np.random.Generator
Curve = Callable[[Array], Array]

WEIGHT = 1.04e-3 * 9.81  # mN/mm3
SPECTRUM_NODES = 41


@dataclass(frozen=True, eq=False)
class Trial:
    """A test while its record is made.

    Parameters
    ----------
    mode : str
        `tension`, `compression` or `shear`.
    time : (n,) float64
        Laboratory clock [s], finer than the record.
    travel : (n,) float64
        Travel of the platen [mm], >= 0.
    stroke, height : float
        Largest travel and height of the sample [mm].
    mu : float
        Shear modulus of the tissue [Pa].
    curves : mapping
        Force over modulus [mm2] as a function of travel [mm], by mode.
    loop : callable
        What a slipping sample's force over modulus is more on unloading, in compression.
    """

    mode: str
    time: Array
    travel: Array
    stroke: float
    height: float
    mu: float
    curves: Mapping[str, Curve]
    loop: Curve = np.zeros_like

    @property
    def sign(self) -> float:
        """-1 in compression."""
        return -1.0 if self.mode == "compression" else 1.0

    @property
    def comes_back(self) -> Mask:
        """Whether the platen goes back, (n,)."""
        last = len(self.travel) - 1 - int(np.argmax(self.travel[::-1]))
        return np.arange(len(self.travel)) > last

    def elastic(self, travel: Array) -> Array:
        """Elastic force along the travel [N]; compression only pushes."""
        scale = 1e-6 * self.mu
        if self.mode == "compression":
            return scale * self.curves[self.mode](np.maximum(travel, 0.0))
        back = self.curves["compression" if self.mode == "tension" else "shear"]
        ahead = self.curves[self.mode](np.maximum(travel, 0.0))
        return scale * np.where(travel >= 0.0, ahead, -back(np.maximum(-travel, 0.0)))


Change = Callable[[Trial, Array], Array]


def _unchanged(test: Trial, values: Array) -> Array:
    return values


@dataclass(frozen=True, eq=False)
class Fault:
    """One thing that is wrong in an experiment.

    Parameters
    ----------
    name : str
        Name of the effect, or of a kind without name.
    sizes : mapping
        What was planted, under the name and unit of the loop's answer where the two mean the same.
    curve : str
        Changed elastic curve, if it is one.
    travel, tissue, instrument : callable
        What becomes of the travel [mm], of the tissue's force and of the cell's force [N].
    swap : tuple of str
        Two modes whose records change their labels.
    """

    name: str
    sizes: Mapping[str, float] = field(default_factory=dict)
    curve: str = ""
    travel: Change = _unchanged
    tissue: Change = _unchanged
    instrument: Change = _unchanged
    swap: tuple[str, str] | None = None


Maker = Callable[[Random, Body, float], Fault]


def _either(random: Random) -> float:
    return float(random.choice([-1.0, 1.0]))


def _about(random: Random, value: float) -> float:
    """Within a tenth of a value, so that sizes lie off every grid."""
    return value * float(random.uniform(0.9, 1.1))


# ---- the tissue's history


def _faded(test: Trial, force: Array, lost: Array) -> Array:
    """Each increment of the force loses the part `lost` (n,) of its age."""
    step = np.diff(force, prepend=0.0)
    return force - np.asarray(fftconvolve(step, lost))[: len(force)]


def _relaxation(random: Random, body: Body, size: float) -> Fault:
    g, middle, width = _about(random, 0.3 * size), _about(random, 10.0), random.uniform(0.7, 1.1)
    x, w = np.polynomial.hermite_e.hermegauss(SPECTRUM_NODES)
    times = middle * np.exp(width * x)

    def tissue(test: Trial, force: Array) -> Array:
        age = test.time - test.time[0]
        spectrum = -np.expm1(-age[:, None] / times) @ (w / w.sum())
        return _faded(test, force, min(g, 0.9) * spectrum)

    return Fault("viscoelastic_relaxation", {"g": g, "tau_s": middle}, tissue=tissue)


def _drainage(random: Random, body: Body, size: float) -> Fault:
    g, slowest = _about(random, 0.1 * size), _about(random, 300.0)

    def tissue(test: Trial, force: Array) -> Array:
        if test.mode == "shear":
            return force
        age = test.time - test.time[0]
        odd = np.arange(1, 40, 2)
        kept = np.exp(-np.outer(age, odd**2) / slowest) @ (8.0 / (np.pi * odd) ** 2)
        return _faded(test, force, g * (1.0 - kept / kept[0]))

    return Fault("poroelastic_drainage", {"g": g, "tau_s": slowest}, tissue=tissue)


def _softening(random: Random, body: Body, size: float) -> Fault:
    d, width = _about(random, 0.2 * size), random.uniform(0.4, 0.7)

    def tissue(test: Trial, force: Array) -> Array:
        push = np.clip(test.elastic(test.travel), 0.0, None)
        work = cumulative_trapezoid(push, test.travel, initial=0)
        below = np.maximum.accumulate(work) - work
        return force * (1.0 - min(d, 0.9) * erf(below / (width * work.max())))

    return Fault("mullins_softening", {"d": d}, tissue=tissue)


def _drying(random: Random, body: Body, size: float) -> Fault:
    rate, slow = _about(random, 0.03 * size), 500.0

    def tissue(test: Trial, force: Array) -> Array:
        return force * (1.0 - 0.01 * rate * slow * np.expm1(-test.time / slow))

    return Fault("dehydration", {"per_100_s": rate}, tissue=tissue)


def _peeling(random: Random, body: Body, size: float) -> Fault:
    lost = _about(random, 0.1 * size)

    def tissue(test: Trial, force: Array) -> Array:
        if test.mode == "compression":
            return force
        furthest = np.maximum.accumulate(test.travel) / test.stroke
        return force * (1.0 - lost * np.sin(0.5 * np.pi * furthest) ** 4)

    return Fault("bond_peel", {"lost": lost}, tissue=tissue)


def _asymmetry(random: Random, body: Body, size: float) -> Fault:
    more = _about(random, 0.1 * size) * _either(random)

    def tissue(test: Trial, force: Array) -> Array:
        if test.mode != "compression":
            return force
        return force * (1.0 + more * np.tanh(test.travel / (0.01 * test.height)))

    return Fault("tension_compression_asymmetry", {"more": more}, tissue=tissue)


def _scaled(name: str, part: float, random: Random, body: Body, size: float) -> Fault:
    """A pure scale: the cell's gain; the tissue at the one speed of the protocol."""
    factor = 1.0 + _about(random, part * size)
    return Fault(name, {}, tissue=lambda test, force: factor * force)


# ---- where the sample begins


def _zero(random: Random, body: Body, size: float) -> Fault:
    shift = {mode: _about(random, 0.1 * size) * _either(random) for mode in MODES}
    return Fault(
        "displacement_zero",
        {f"{mode}_mm": value for mode, value in shift.items()},
        travel=lambda test, travel: travel + shift[test.mode],
    )


def _gap(random: Random, body: Body, size: float) -> Fault:
    gap = _about(random, 0.2 * size)

    def travel(test: Trial, travel: Array) -> Array:
        return travel - gap if test.mode == "compression" else travel

    return Fault("late_contact", {"gap_mm": gap}, travel=travel)


def _precompressed(random: Random, body: Body, size: float) -> Fault:
    d = PRESSED * size

    def tissue(test: Trial, force: Array) -> Array:
        if test.mode == "shear":
            return force
        start = d if test.mode == "compression" else -d
        pushed = test.elastic(test.travel + start)
        return force + pushed - test.elastic(np.array([start])) - test.elastic(test.travel)

    return Fault("residual_precompression", {"d_mm": d}, curve="pressed", tissue=tissue)


# ---- the machine


def _play(random: Random, body: Body, size: float) -> Fault:
    play = _about(random, 0.03 * size)

    def travel(test: Trial, travel: Array) -> Array:
        """Play operator: what is pushed rests until the other flank of the gap arrives."""
        behind = np.empty_like(travel)
        at = travel[0]
        for k, x in enumerate(travel.tolist()):
            at = min(max(at, x), x + play)
            behind[k] = at
        return behind

    return Fault("backlash", {"play_mm": play}, travel=travel)


def _compliance(random: Random, body: Body, size: float) -> Fault:
    c = _about(random, 0.05 * size)

    def travel(test: Trial, travel: Array) -> Array:
        own = np.linspace(travel.min() - 0.5, travel.max() + 0.5, 6000)
        return np.interp(travel, own + c * test.elastic(own), own)

    return Fault("machine_compliance", {"mm_per_N": c}, travel=travel)


def _lag(random: Random, body: Body, size: float) -> Fault:
    lag = _about(random, 0.1 * size)

    def instrument(test: Trial, force: Array) -> Array:
        behind = round(lag / (test.time[1] - test.time[0]))
        return np.concatenate([np.full(behind, force[0]), force[: len(force) - behind]])

    return Fault("channel_lag", {"lag_ms": 1e3 * lag}, instrument=instrument)


# ---- the cell


def _offset(random: Random, body: Body, size: float) -> Fault:
    offset = {mode: _about(random, 5.0 * size) * _either(random) for mode in MODES}
    return Fault(
        "force_offset",
        {f"{mode}_mN": value for mode, value in offset.items()},
        instrument=lambda test, force: force + 1e-3 * test.sign * offset[test.mode],
    )


def _drift(random: Random, body: Body, size: float) -> Fault:
    rate, slow = _about(random, 0.1 * size) * _either(random), 900.0

    def instrument(test: Trial, force: Array) -> Array:
        creep = -rate * slow * np.expm1(-(test.time - test.time[0]) / slow)
        return force + 1e-3 * test.sign * creep

    return Fault("force_drift", {"mN_per_s": rate}, instrument=instrument)


def _weight(random: Random, body: Body, size: float) -> Fault:
    weight = -0.5 * WEIGHT * body.volume * size

    def instrument(test: Trial, force: Array) -> Array:
        return force if test.mode == "shear" else force + 1e-3 * test.sign * weight

    return Fault("self_weight", {"weight_mN": weight}, instrument=instrument)


def _sticky(random: Random, body: Body, size: float) -> Fault:
    pull, reach = _about(random, 5.0 * size), random.uniform(0.1, 0.25)

    def instrument(test: Trial, force: Array) -> Array:
        if test.mode != "compression":
            return force
        leaving = 1.0 + 0.5 * (np.gradient(test.travel) < 0.0)
        near = test.travel / reach
        return force - 1e-3 * pull * leaving * (1.0 + near) * np.exp(-1.7 * near)

    return Fault("adhesion", {"force_mN": pull}, instrument=instrument)


def _hum(random: Random, body: Body, size: float) -> Fault:
    period, height = float(np.exp(random.uniform(np.log(1.5), np.log(40.0)))), 2.0 * size
    phase = {mode: random.uniform(0.0, 2.0 * np.pi) for mode in MODES}

    def instrument(test: Trial, force: Array) -> Array:
        angle = 2.0 * np.pi * test.time / period + phase[test.mode]
        return force + 1e-3 * height * (np.sin(angle) + 0.1 * np.sin(2.0 * angle))

    return Fault("mains_pickup", {"period_s": period}, instrument=instrument)


# ---- kinds that the loop has no name for


def _bent_cell(random: Random, body: Body, size: float) -> Fault:
    bend = 0.02 * size * _either(random)

    def instrument(test: Trial, force: Array) -> Array:
        return force * (1.0 + bend * np.sin(np.pi * np.abs(force) / 0.6))

    return Fault("cell_nonlinearity", instrument=instrument)


def _jitter(random: Random, body: Body, size: float) -> Fault:
    seed = int(random.integers(2**31))

    def instrument(test: Trial, force: Array) -> Array:
        """The clock of the force stops now and then for up to 0.6 s, and catches up."""
        own = np.random.default_rng([seed, MODES.index(test.mode)])
        late = np.zeros_like(test.time)
        for start in own.uniform(test.time[0], test.time[-1], 25):
            since = test.time - start
            pause = 0.6 * size * own.uniform(0.3, 1.0)
            late = np.maximum(late, np.where((since > 0.0) & (since < pause), since, 0.0))
        return np.interp(test.time - late, test.time, force)

    return Fault("clock_jitter", instrument=instrument)


def _warming(random: Random, body: Body, size: float) -> Fault:
    softer, middle = 0.05 * size, random.uniform(30.0, 50.0)

    def tissue(test: Trial, force: Array) -> Array:
        return force * (1.0 - softer * 0.5 * (1.0 + np.tanh((test.time - middle) / 3.0)))

    return Fault("temperature_ramp", tissue=tissue)


def _stick_slip(random: Random, body: Body, size: float) -> Fault:
    jump, length = 0.02 * size, random.uniform(0.3, 0.7)

    def tissue(test: Trial, force: Array) -> Array:
        moving = np.abs(np.gradient(test.travel)) > 0.0
        saw = np.mod(test.travel / length, 1.0) - 0.5
        return force * (1.0 + jump * saw * moving)

    return Fault("stick_slip", tissue=tissue)


def _mixed_labels(random: Random, body: Body, size: float) -> Fault:
    return Fault("mixed_labels", swap=("tension", "shear"))


def _of_curve(
    name: str, curve: str, sizes: Callable[[float], Mapping[str, float]] = lambda size: {}
) -> Maker:
    """A changed model, simulated beforehand."""
    return lambda random, body, size: Fault(name, sizes(size), curve=curve)


def _slip(random: Random, body: Body, size: float) -> Fault:
    """Friction turns round with the platen."""

    def tissue(test: Trial, force: Array) -> Array:
        if test.mode != "compression":
            return force
        return force + np.where(test.comes_back, 1e-6 * test.mu * test.loop(test.travel), 0.0)

    return Fault("platen_slip", curve="slip", tissue=tissue)


@dataclass(frozen=True)
class Kind:
    """A kind of fault, as the page of the laboratory describes it.

    Parameters
    ----------
    make : callable
        From random numbers, body and multiple of the nominal size.
    nominal : str
        The size called 1x.
    form : str
        The laboratory's formula.
    imperfect : bool
        Whether it needs a sample of imperfect shape.
    """

    make: Maker
    nominal: str
    form: str
    imperfect: bool = False


EFFECTS: dict[str, Kind] = {
    "viscoelastic_relaxation": Kind(_relaxation, "g 0.3, 10 s", "log-normal spectrum of times"),
    "mullins_softening": Kind(_softening, "d 0.2", "error function of the recovered work"),
    "residual_precompression": Kind(
        _precompressed,
        f"{PRESSED} mm",
        "own run of shear from that state; tension and compression curve joined",
    ),
    "poroelastic_drainage": Kind(_drainage, "g 0.1, 300 s", "consolidation series, axial tests"),
    "dehydration": Kind(_drying, "3 % in 100 s", "saturating growth, 500 s"),
    "displacement_zero": Kind(_zero, "0.1 mm, a sign for each test", "shifted displacement"),
    "late_contact": Kind(_gap, "0.2 mm", "shifted displacement in compression"),
    "platen_tilt": Kind(
        _of_curve("platen_tilt", "tilt", lambda s: {"tilt_deg": s}),
        "1 degree",
        "own run, any direction",
    ),
    "real_geometry": Kind(
        _of_curve("real_geometry", "shape"),
        "a random phantom",
        "own run on its mesh",
        imperfect=True,
    ),
    "partial_bond": Kind(
        _of_curve("partial_bond", "strip", lambda s: {"missing": 0.125 * s}),
        "12.5 %",
        "own run, strip on any side",
    ),
    "bond_peel": Kind(_peeling, "10 % at peak", "sin^4 of the largest displacement"),
    "platen_slip": Kind(
        _slip, "coefficient 0.25", "own run with Coulomb friction, loading and unloading"
    ),
    "machine_compliance": Kind(_compliance, "0.05 mm/N", "spring in series, solved"),
    "poisson_ratio": Kind(
        _of_curve("poisson_ratio", "poisson", lambda s: {"nu": 0.49 - 0.01 * s}), "0.48", "own run"
    ),
    "boundary_shift": Kind(
        _of_curve("boundary_shift", "larger", lambda s: {"shift_mm": 0.1 * s}),
        "0.1 mm",
        "own run of a larger cuboid",
    ),
    "ogden_exponents": Kind(
        _of_curve("ogden_exponents", "third_term"),
        "3.3 % of mu at alpha -15",
        "own run with three terms",
    ),
    "tension_compression_asymmetry": Kind(_asymmetry, "10 %", "hyperbolic tangent of the strain"),
    "anisotropy": Kind(
        _of_curve("anisotropy", "fibres"),
        "k1 4 % of mu",
        "own run, fibres 15 degrees off the axis",
    ),
    "self_weight": Kind(_weight, "half the weight", "constant, axial tests"),
    "adhesion": Kind(_sticky, "5 mN", "(1 + u/a) exp(-1.7 u/a), half more on unloading"),
    "force_offset": Kind(_offset, "5 mN, a sign for each test", "constant"),
    "force_drift": Kind(_drift, "0.1 mN/s", "creep of 900 s"),
    "channel_lag": Kind(_lag, "0.1 s", "delay on the finer clock"),
    "backlash": Kind(_play, "0.03 mm", "play operator"),
    "mains_pickup": Kind(_hum, "2 mN, 1.5 to 40 s", "sine with a second harmonic"),
}
"""What a test at one speed can identify, by the names of the loop."""

SCALES: dict[str, Kind] = {
    "gain": Kind(partial(_scaled, "gain", 0.01), "1 %", "factor"),
    "rate_stiffening": Kind(
        partial(_scaled, "rate_stiffening", 0.15), "15 %", "factor at one speed"
    ),
}
"""What is nothing but another modulus."""

STRANGERS: dict[str, Kind] = {
    "stiff_inclusion": Kind(
        _of_curve("stiff_inclusion", "inclusion"), "a ball, six times as stiff", "own run"
    ),
    "cell_nonlinearity": Kind(_bent_cell, "2 %", "sine of the force, period 1.2 N"),
    "clock_jitter": Kind(_jitter, "25 pauses of up to 0.6 s", "late time stamps"),
    "temperature_ramp": Kind(_warming, "5 % softer in the hold", "step of 3 s"),
    "stick_slip": Kind(_stick_slip, "2 %", "sawtooth while the platen moves"),
    "mixed_labels": Kind(_mixed_labels, "tension and shear", "records change their labels"),
}
"""Kinds that no file of the library describes."""

KINDS = {**EFFECTS, **SCALES, **STRANGERS}
