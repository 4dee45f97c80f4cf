"""A made-up laboratory for the loop: its own elastic curves, protocol, noise and effects.

Nothing here comes from `softsample.loop.effects`; curves are simple formulas, not simulations.
"""

from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.signal import fftconvolve
from scipy.special import erf

from softsample.constitutive.ogden import unit_modulus
from softsample.loop.model import Material, Model, State
from softsample.loop.noise import Noise, covariances
from softsample.loop.specimen import Specimen, blocks
from softsample.records import Record
from softsample.report import verdict
from softsample.response.curves import ResponseCurves, before_zero
from softsample.response.elastic import Elastic, Tables
from softsample.response.law_response import LawResponse
from softsample.response.unit import (
    ResponseSettings,
    homogeneous_response,
    modulus_fractions,
    response_table,
)
from softsample.shapes import IdealShape

page = partial(verdict.page, Path(__file__).parents[1] / "workflow/report/verdict.md.j2")
"""Page of a group and its verdict, in the words of the workflow."""

MODES = ("tension", "compression", "shear")
SIGN = {"tension": 1.0, "compression": -1.0, "shear": 1.0}
STROKE = {"tension": 3.5, "compression": 3.0, "shear": 6.5}  # mm
HEIGHT, AREA = 13.0, 460.0  # mm, mm2
SHAPE = IdealShape("cuboid", 23e-3, 20e-3, 1e-3 * HEIGHT)
ALPHA = (-8.0, 16.0)
SPEED, RATE = 0.3, 100.0  # mm/s, Hz
REST, HOLD = 2.0, 60.0  # s
WHITE, SLOW, SLOW_TIME, READING = 1.0e-3, 0.5e-3, 1.0, 1e-3  # N, N, s, mm
MU, FRACTION = 1000.0, 0.7  # Pa, 1


def area(mode, r, u):
    """Force over shear modulus [mm2] of travel u >= 0 [mm]."""
    e = np.clip(u, 0.0, None) / HEIGHT
    if mode == "tension":
        return AREA * 3.0 * e / (1.0 + (1.0 + 2.0 * r**2) * e) * (1.0 + 4.0 * (1.0 - r) * e)
    if mode == "compression":
        b = 3.0 + 3.5 * r
        return AREA * 3.0 / b * np.expm1(b * e) * -np.expm1(-np.clip(u, 0.0, None) / 0.8)
    return AREA * e * (1.0 + (2.0 + 5.0 * (1.0 - r)) * e**2)


def pulled(mode, r, u):
    """The same for both signs of the travel; compression lets go."""
    return area(mode, r, u) if mode == "compression" else np.sign(u) * area(mode, r, abs(u))


CHANGES = {  # of the force over the modulus: factor of strain e, for the modes that feel it
    "poisson_0.02_less": {
        "tension": (0.025, 0.06),
        "compression": (0.08, 0.4),
        "shear": (0.0, 0.01),
    },
    "poisson_0.09_less": {
        "tension": (0.075, 0.17),
        "compression": (0.25, 1.2),
        "shear": (0.0, 0.035),
    },
    "fibres_x": {"tension": (-0.05, 0.0), "compression": (-0.05, -0.1), "shear": (-0.2, 0.1)},
    "fibres_z": {"tension": (-0.2, -0.2), "compression": (-0.15, 0.3), "shear": (0.0, -0.3)},
    "fibres_ahead": {"tension": (-0.03, 0.0), "compression": (-0.03, 0.0), "shear": (-0.3, -0.4)},
    "fibres_behind": {"tension": (-0.03, 0.0), "compression": (-0.03, 0.0), "shear": (-0.3, 0.4)},
    "boundary_shift": {
        "tension": (-0.006, 0.0),
        "compression": (-0.02, 0.01),
        "shear": (-1e-3, 0.0),
    },
    "pressed": {"shear": (0.03, 0.02)},
    "partial_bond_ahead": {"tension": (0.05, -0.02), "shear": (0.04, 0.03)},
    "partial_bond_behind": {"tension": (0.05, -0.02), "shear": (0.04, -0.04)},
    "partial_bond_beside": {"tension": (0.05, -0.02), "shear": (0.02, 0.01)},
    "platen_tilt_x": {"compression": (0.1, -0.4)},
    "platen_tilt_minus_x": {"compression": (0.1, -0.4)},
    "platen_tilt_y": {"compression": (0.12, -0.45)},
    "platen_tilt_minus_y": {"compression": (0.12, -0.45)},
    "platen_slip": {"compression": (0.25, 0.6)},
}
"""Loss of force a + b e as a part of it; made up, of the sizes that LOOP's pre-study found."""


def elastic(mode):
    """The model of a perfect laboratory."""
    travel = np.linspace(0.0, 1.1 * STROKE[mode], 121)
    fractions = modulus_fractions(ResponseSettings())
    curves = ResponseCurves(
        fractions,
        1e-3 * travel,
        1e-6 * np.stack([area(mode, r, travel) for r in fractions]),
        before_zero(mode),
    )
    middle = 1e-6 * area(mode, FRACTION, travel)
    changes = {
        name: -(of[mode][0] + of[mode][1] * travel / HEIGHT) * middle
        for name, of in CHANGES.items()
        if mode in of
    }
    laws = LawResponse(curves, SHAPE, mode, ALPHA, 0.49)
    laws = replace(laws, runs={alpha: run(laws, alpha) for alpha in (-45.0, 40.0)})
    return Elastic(
        curves, alike(curves, changes), mode == "compression", laws=laws, height=SHAPE.height
    )


def alike(curves, changes):
    """Changes (n,) at the displacements of some curves, the same for all fractions."""
    return {
        name: ResponseCurves(np.array([0.5]), curves.displacement, change[None], curves.before)
        for name, change in changes.items()
    }


def run(laws, alpha):
    """Force of a single term, as much above its closed form as the nearer one of the model's."""
    travel = laws.curves.displacement
    change = laws.ogden_change(1.0, travel, (alpha, ALPHA[1]))
    return laws.curves.force_per_mu(1.0, travel) + change


def exact(mode, shape=SHAPE, reach=None, nu=0.49):
    """The model of a specimen with sliding ends, in closed form, to a strain."""
    travel = (reach or 1e-3 * STROKE[mode] / shape.height) * shape.height
    fractions = modulus_fractions(ResponseSettings())
    columns, _ = homogeneous_response(shape, mode, travel, fractions, ALPHA, nu, 120)
    solid = unit_modulus(0.5, ALPHA, nu, 1.0)
    table = pd.DataFrame(response_table(columns, mode))
    return Elastic.of_tables(mode, Tables(table, [], solid), shape=shape)


def clock(mode):
    """Time [s] and true travel [mm]: rest, ramp, hold, back."""
    way = STROKE[mode] / SPEED
    knots = np.cumsum([0.0, REST, way, HOLD, way])
    time = np.arange(0.0, knots[-1], 1.0 / RATE)
    return time, np.interp(time, knots, [0.0, 0.0, STROKE[mode], STROKE[mode], 0.0])


@dataclass
class Lab:
    """Records of one animal; keywords plant effects.

    Signs of instruments are those of the machine: positive is up, or along +x.
    """

    seed: int = 0
    mu: float = MU
    offset: dict = field(default_factory=dict)  # mN by mode
    drift: float = 0.0  # mN/s
    lag: int = 0  # samples
    relaxed: float = 0.0  # part of the force that a stretched exponential takes
    damage: float = 0.0
    compliance: float = 0.0  # mm/N
    gap: float = 0.0  # mm
    slack: float = 0.0  # mm
    play: float = 0.0  # mm
    weight: float = 0.0  # mN
    zero: dict = field(default_factory=dict)  # mm along the travel, by mode
    steps: float = 0.0  # mN, stick and slip: in no library

    def travel(self, mode, u):
        """Travel that reaches the sample [mm]."""
        late = {"compression": self.gap, "tension": self.slack}.get(mode, 0.0)
        s = u + self.zero.get(mode, 0.0) - late
        if self.slack and mode == "tension":
            s = np.maximum(s, 0.0)
        if self.play:
            reached = np.empty_like(s)
            at = s[0]
            for k, x in enumerate(s):
                at = min(max(at, x), x + self.play)
                reached[k] = at
            s = reached
        if self.compliance:  # s + c F(s) is what the machine sees
            fine = np.linspace(-1.0, 1.1 * STROKE[mode], 4000)
            seen = fine + self.compliance * 1e-6 * self.mu * pulled(mode, FRACTION, fine)
            s = np.interp(s, seen, fine)
        return s

    def tissue(self, mode, time, s):
        """Force of the sample along the travel [N]."""
        force = 1e-6 * self.mu * pulled(mode, FRACTION, s)
        if self.relaxed:
            kept = 1.0 - self.relaxed * -np.expm1(-((time / 9.0) ** 0.6))
            force = fftconvolve(np.diff(force, prepend=0.0), kept)[: len(force)]
        if self.damage:  # Ogden and Roxburgh: error function of the energy that is given back
            work = np.cumsum(area(mode, FRACTION, s) * np.gradient(s))
            below = np.maximum.accumulate(work) - work
            force = force * (1.0 - self.damage * erf(below / (0.5 * work.max())))
        return np.maximum(force, 0.0) if mode == "compression" else force

    def record(self, mode):
        """What the machine writes, as a table."""
        rng = np.random.default_rng([self.seed, MODES.index(mode)])
        time, u = clock(mode)
        force = SIGN[mode] * self.tissue(mode, time, self.travel(mode, u))
        force = force + 1e-3 * (self.offset.get(mode, 0.0) + self.drift * time)
        if mode != "shear":
            force = force + 1e-3 * self.weight
        if self.steps:
            force = force + 1e-3 * self.steps * np.sign(np.sin(11.0 * u)) * (u > 0.5)
        if self.lag:
            force = np.concatenate([np.full(self.lag, force[0]), force[: -self.lag]])
        keep = np.exp(-1.0 / RATE / SLOW_TIME)
        slow = np.empty(len(time))
        slow[0] = rng.normal(0.0, SLOW)
        for k, kick in enumerate(rng.normal(0.0, SLOW * np.sqrt(1.0 - keep**2), len(time) - 1)):
            slow[k + 1] = keep * slow[k] + kick
        return pd.DataFrame(
            {
                "time_s": time,
                "displacement_mm": SIGN[mode] * u + rng.normal(0.0, READING, len(time)),
                "force_N": force + slow + rng.normal(0.0, WHITE, len(time)),
            }
        )

    def specimens(self, modes=MODES, names=None):
        """The tests as the loop reads them."""
        names = names or [f"{mode[0].upper()}{self.seed}" for mode in modes]
        return [
            Specimen.of_record(name, mode, record_of(self.record(mode), mode), elastic(mode))
            for name, mode in zip(names, modes, strict=True)
        ]


def record_of(table, mode):
    """Record of what a machine wrote, its phases found."""
    return Record.of_table(table).marked(mode)


PLANTED = {
    "force_offset": Lab(offset={"tension": 7.0, "compression": -5.0, "shear": 4.0}),
    "force_drift": Lab(drift=0.1),
    "channel_lag": Lab(lag=12),
    "viscoelastic_relaxation": Lab(relaxed=0.4),
    "mullins_softening": Lab(damage=0.3),
    "machine_compliance": Lab(compliance=0.18),
    "late_contact": Lab(gap=0.3),
    "backlash": Lab(play=0.06),
    "self_weight": Lab(weight=-30.0),
    "displacement_zero": Lab(zero={"tension": 0.15, "compression": -0.2, "shear": 0.2}),
}
"""Records with one effect of the library, made by other formulas."""


def foam_cycle(name, shape, mu, alpha, loss, strain, *, step=0.05, seed=5):
    """A plug of Storakers' foam, Poisson's ratio 0, pressed once between plates that slide.

    A part of its force is missing on unloading. 2 s of rest, then 1 % a second to a strain and
    back.
    """
    rng, way = np.random.default_rng(seed), strain / 0.01
    knots = np.cumsum([0.0, 2.0, way, way])
    time = np.arange(0.0, knots[-1], step)
    reached = np.interp(time, knots, [0.0, 0.0, strain, 0.0])
    back = np.clip((strain - reached) / (0.1 * strain), 0.0, 1.0) * (time > knots[2])
    force = foam_force(shape, mu, alpha, reached) * (1.0 - loss * back * (2.0 - back))
    force = force + 2e-4 * rng.normal(size=len(time))
    phase = np.select([time < knots[1], time < knots[2]], ["baseline", "ramp"], "unloading")
    elastic = exact("compression", shape, 1.05 * strain)
    return Specimen(name, "compression", time, reached * shape.height, force, phase, elastic)


def foam_force(shape, mu, alpha, strain):
    """Force [N] of that plug: its width stays, so that the nominal stress is of one stretch."""
    stretch = 1.0 - strain
    return shape.area * 2.0 * mu / alpha * (1.0 / stretch - stretch ** (alpha - 1.0))


def drawn(specimens, settings, sizes, seed):
    """The same with errors of the settings' forms and of other sizes, drawn for each test."""
    rng, made = np.random.default_rng(seed), []
    for specimen in specimens:
        model = Model().predict(specimen, State(Material(MU, FRACTION)))
        few = specimen.reduced(20)
        _, parts = covariances(few, Noise(0.0, 0.0, 1), blocks(model, 20), settings, 1)
        total = sum(size**2 * parts[name] for name, size in sizes.items())
        error = np.linalg.cholesky(total + 1e-12 * np.eye(len(total))) @ rng.normal(size=len(total))
        made.append(replace(specimen, force=specimen.force + np.interp(
            specimen.time, few.time, error)))  # fmt: skip
    return made
