"""Every file of the library: neutral where it says so, complete, and listed in the docs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import effects_page
import laboratory
from softsample.constitutive.ogden import OgdenMaterial
from softsample.loop.effects import library
from softsample.loop.effects.base import MODES, SOLID
from softsample.loop.history import drained, followed, relaxed
from softsample.loop.model import Material, Model, State
from softsample.loop.specimen import AHEAD, NORMAL, Specimen
from softsample.response.curves import ResponseCurves
from softsample.response.elastic import Elastic

EFFECTS = library()
OF_SIZE = {name: effect for name, effect in EFFECTS.items() if name != "ends"}
ROOT = Path(__file__).resolve().parents[2]
NAMES = set(
    """viscoelastic_relaxation rate_stiffening mullins_softening residual_precompression
poroelastic_drainage dehydration displacement_zero late_contact platen_tilt real_geometry
partial_bond bond_peel platen_slip machine_compliance poisson_ratio boundary_shift ogden_exponents
tension_compression_asymmetry anisotropy self_weight adhesion ends force_offset force_drift
channel_lag backlash mains_pickup gain uneven_contact unloading_loss permanent_set slack
channel_crosstalk specimen_stiffness mode_ratio compressible_foam elastic_law""".split()  # noqa: SIM905 - the list as the design has it
)
UNITS = {"1", "mm", "mN", "mN/s", "ms", "s", "mm/N", "deg", "mu"}


@pytest.fixture(scope="module")
def specimens():
    found = laboratory.Lab(compliance=0.05).specimens()
    for specimen in found:  # made up as the others: the cuboid is too stiff
        curves = specimen.elastic.curves
        force = curves.force_per_mu(0.7, curves.displacement)
        specimen.elastic.perturbations.update(
            laboratory.alike(curves, {"real_geometry": -0.1 * force})
        )
    return [*found, *(replace(s, piece=f"{s.piece}_again") for s in found), with_normal(found[2])]


def with_normal(shear):
    """The normal force of a test of shear, a tenth of the other and the same to both sides."""
    own = shear.elastic.curves
    forces = np.stack([0.1 * own.curve(r) for r in own.fractions])
    curves = ResponseCurves(own.fractions, own.displacement, forces, "even")
    elastic = Elastic(curves, {})
    force = 0.1 * shear.force
    return replace(shear, elastic=elastic, force=force, channel=NORMAL, partner=shear)


@pytest.fixture(scope="module")
def known(specimens):
    """The library for these tests."""
    return library(SOLID, specimens)


def homogeneous():
    """Specimens in the place of the others whose response is that of sliding ends."""
    found = laboratory.Lab().specimens()
    return [replace(s, elastic=laboratory.exact(s.mode)) for s in found]


def predicted(specimen, effect, values):
    model = Model((effect,))
    return model.predict(specimen, State(Material(1000.0, 0.7), {effect.name: values}))


def test_the_library_holds_the_names_of_the_design_and_no_others():
    assert set(EFFECTS) == NAMES


def test_ends_are_a_model_of_their_own_and_no_candidate():
    assert [name for name, effect in EFFECTS.items() if not effect.parameters] == ["ends"]
    assert not EFFECTS["ends"].identifiable


@pytest.mark.parametrize("name", OF_SIZE)
def test_an_effect_is_absent_at_its_neutral_values_wherever_else_its_shape_lies(
    name, specimens, known
):
    effect = known[name]
    for specimen in specimens:
        plain = Model().predict(specimen, State(Material(1000.0, 0.7)))
        for last in (0, -1):
            shapes = {p.name: p.grid[last] for p in effect.parameters if not p.is_size}
            force = predicted(specimen, effect, {**effect.neutral(), **shapes})
            np.testing.assert_allclose(force, plain, atol=1e-12)


@pytest.mark.parametrize("name", OF_SIZE)
def test_an_effect_changes_the_modes_it_names_and_no_others(name, specimens, known):
    effect = known[name]
    if name == "compressible_foam":  # not known of curves that are so far from any law
        specimens = homogeneous()
    high = {p.name: p.high if p.is_size else p.grid[0] for p in effect.parameters}
    changed = set()
    for specimen in specimens:
        plain = Model().predict(specimen, State(Material(1000.0, 0.7)))
        if np.abs(predicted(specimen, effect, high) - plain).max() > 1e-4:
            changed.add(specimen.mode)
    assert changed == set(effect.modes)


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)
def test_a_file_says_units_ranges_source_confusions_and_experiment(effect):
    assert set(effect.modes) <= set(MODES)
    for text in (effect.title, effect.source, effect.signature, effect.experiment):
        assert len(text) > 5 or text == "a scale"
    assert effect.confused_with
    assert set(effect.confused_with) <= set(EFFECTS) - {effect.name}
    for p in effect.parameters:
        assert p.unit in UNITS
        assert p.low < p.high
        assert p.low <= p.nominal <= p.high
        known = effect.idealised  # its size is simulated on the imaged shape: there, or not there
        assert not p.is_size or known or p.low <= p.neutral <= p.high
        assert all(p.low <= value <= p.high for value in p.grid)
    assert effect.sizes or effect.name not in OF_SIZE


def test_relaxation_is_the_convolution_of_the_modulus_with_the_growth_of_the_force():
    """Against the integral of a cubic history, term by term, by hand."""
    g, tau, end = 0.4, 3.0, 8.0
    time = np.linspace(0.0, end, 4001)
    # int_0^t (1 - exp(-(t - s)/tau)) 3 s^2 ds
    decayed = tau * (time**2 - 2.0 * tau * time + 2.0 * tau**2 * -np.expm1(-time / tau))
    exact = time**3 - g * (time**3 - 3.0 * decayed)
    np.testing.assert_allclose(relaxed(time, time**3, g, tau), exact, atol=1e-4 * end**3)


def test_drainage_begins_with_the_square_root_of_time():
    """Against Terzaghi's law for small times, ``(4 / pi) sqrt(t / (pi tau))``; whole at the end."""
    g, tau = 0.1, 300.0
    time = np.linspace(0.0, 5.0 * tau, 150001)
    lost = 1.0 - drained(time, np.ones_like(time), g, tau)
    early = (time > 0.04 * tau) & (time < 0.2 * tau)
    exact = g * 4.0 / np.pi * np.sqrt(time[early] / (np.pi * tau))
    np.testing.assert_allclose(lost[early], exact, rtol=0.03)
    assert lost[-1] == pytest.approx(g, rel=0.01)


def test_relaxation_is_exact_for_a_ramp_whatever_the_step():
    g, tau = 0.5, 0.7
    for step in (0.01, 1.0):
        time = np.arange(0.0, 10.0, step)
        exact = time - g * (time + tau * np.expm1(-time / tau))
        np.testing.assert_allclose(relaxed(time, time, g, tau), exact, rtol=1e-12, atol=1e-12)


def test_relaxation_is_exact_for_a_ramp_and_a_hold_at_uneven_times():
    """A machine that thins the hold; corners at samples."""
    g, tau, way = 0.5, 10.0, 10.0
    time = np.concatenate([np.arange(0.0, way, 0.01), way + np.arange(0.0, 101.0, 1.0)])
    force = np.minimum(time, way)
    since = time - way
    rising = time + tau * np.expm1(-time / tau)
    held = way + tau * (np.exp(-time / tau) - np.exp(-since / tau))
    exact = force - g * np.where(since < 0.0, rising, held)
    np.testing.assert_allclose(relaxed(time, force, g, tau), exact, rtol=1e-9, atol=1e-9)


def relaxing_strip(time, strain, nu, g, tau, bulk_relaxes):
    """Stress per shear modulus of a strip that is stretched between rigid walls, step by step.

    Plane strain: along the walls it cannot move, across it is free. The deviatoric stress relaxes,
    and the pressure or not; the strain across is found anew at every step.
    """
    bulk = 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
    step = np.diff(time, prepend=2.0 * time[0] - time[1]) / tau
    decay, gain = np.exp(-step), -np.expm1(-step) / step
    strains = np.array([[2.0, -1.0], [-1.0, 2.0], [3.0, 3.0]]) / 3.0  # deviators and volume
    elastic = strains * [[2.0], [2.0], [bulk]]  # stresses, by the strain along and across
    share = np.array([g, g, g if bulk_relaxes else 0.0])
    kept, before, found = np.zeros(3), np.zeros(3), np.empty_like(time)
    for k in range(len(time)):
        now = (1.0 - share + share * gain[k])[:, None] * elastic
        past = share * (decay[k] * kept - gain[k] * before)
        along, across = now[0] + now[2], now[1] + now[2]
        narrowing = -(strain[k] * across[0] + past[1] + past[2]) / across[1]
        found[k] = along @ [strain[k], narrowing] + past[0] + past[2]
        after = elastic @ [strain[k], narrowing]
        kept, before = decay[k] * kept + gain[k] * (after - before), after
    return found


def strip(nu, time, strain):
    """Specimen of such a strip with runs of other Poisson's ratios, ``F / mu = 2 / (1 - nu)``."""
    ends = np.array([0.0, 1.0])
    runs = {f"poisson_{less}_less": 2.0 / (1.0 - nu + less) for less in (0.02, 0.09)}
    base = 2.0 / (1.0 - nu)
    changes = {name: (run - base) * ends for name, run in runs.items()}
    curves = ResponseCurves(np.array([0.5]), ends, base * ends[None])
    elastic = Elastic(curves, laboratory.alike(curves, changes), poisson_ratio=nu)
    phase = np.full(len(time), "ramp")
    return Specimen("strip", "tension", time, strain, np.zeros_like(time), phase, elastic)


def test_a_glued_platen_pulls_on_what_has_relaxed():
    time = np.arange(0.0, 40.0, 0.02)
    strain = np.interp(time, [0.0, 10.0, 30.0, 40.0], [0.0, 1.0, 1.0, 0.0])
    free = strip(0.42, time, strain)
    values = {"g1": 0.4, "tau1_s": 8.0, "g2": 0.0, "g3": 0.0, "tau3_s": 60.0, "bulk": 0.0}
    model = Model((EFFECTS["viscoelastic_relaxation"],))
    state = State(Material(1.0, 0.5), {"viscoelastic_relaxation": values})
    wanted = model.predict(free, state)
    assert wanted.min() < -0.1 * wanted.max()
    for release, least in ((False, -np.inf), (True, 0.0)):
        pressed = replace(free, elastic=replace(free.elastic, contact=True, release=release))
        np.testing.assert_array_equal(model.predict(pressed, state), np.maximum(wanted, least))


@pytest.mark.parametrize("g", [0.3, 0.6])
@pytest.mark.parametrize("bulk", [0.0, 1.0])
def test_a_bulk_modulus_that_stays_is_felt_as_in_a_strip_between_walls(bulk, g):
    nu, tau = 0.42, 8.0
    time = np.arange(0.0, 40.0, 0.02)
    strain = np.interp(time, [0.0, 10.0, 30.0, 40.0], [0.0, 1.0, 1.0, 0.0])
    specimen = strip(nu, time, strain)
    values = {"g1": g, "tau1_s": tau, "g2": 0.0, "g3": 0.0, "tau3_s": 60.0, "bulk": bulk}
    effect = EFFECTS["viscoelastic_relaxation"]
    force = Model((effect,)).predict(specimen, State(Material(1.0, 0.5), {effect.name: values}))
    spared, relaxing = (relaxing_strip(time, strain, nu, g, tau, way) for way in (False, True))
    exact = spared if bulk else relaxing
    apart = np.abs(spared - relaxing).max()
    assert apart > 0.02 * spared.max()
    np.testing.assert_allclose(force, exact, atol=0.1 * apart)


def test_what_a_bulk_modulus_that_stays_adds_vanishes_as_the_platen_leaves():
    """Continuous: fits go astray where a force jumps."""
    time = np.arange(0.0, 20.0, 0.1)
    way = np.interp(time, [0.0, 10.0, 20.0], [0.0, 1.0, 0.0])
    pressed = strip(0.42, time, way)
    known = pressed.elastic.curves
    curves = ResponseCurves(known.fractions, known.displacement, known.curve(0.5)[None], "none")
    elastic = replace(pressed.elastic, curves=curves, contact=True)
    effect, specimen = EFFECTS["viscoelastic_relaxation"], replace(pressed, elastic=elastic)
    values = {"g1": 0.5, "tau1_s": 8.0, "g2": 0.0, "g3": 0.0, "tau3_s": 60.0, "bulk": 1.0}
    touching, leaving = (
        effect.elastic(specimen, 0.5, way - way[-1] - off, values) for off in (-1e-6, 1e-6)
    )
    assert touching.max() > 0.05
    np.testing.assert_allclose(leaving, touching, atol=1e-4)


def test_play_is_used_up_at_each_reversal():
    travel = np.array([0.0, 1.0, 3.0, 2.9, 2.0, 0.0, 0.05, 1.0, 3.0, 4.0, 3.95])
    expected = [0.0, 1.0, 3.0, 3.0, 2.1, 0.1, 0.1, 1.0, 3.0, 4.0, 4.0]
    np.testing.assert_allclose(followed(travel, 0.1), expected)
    later = [0.0, 0.9, 2.9, 2.9, 2.0, 0.0, 0.0, 0.9, 2.9, 3.9, 3.9]
    for ahead, found in ((0.0, expected), (1.0, later)):
        values = {"play_mm": 0.1, "ahead": ahead}
        reached = EFFECTS["backlash"].travel(None, 1e-3 * travel, values)
        np.testing.assert_allclose(reached, 1e-3 * np.array(found), atol=1e-12)


def test_an_effect_does_not_depend_on_when_the_clock_was_started(specimens, known):
    for effect in known.values():
        high = {p.name: p.high if p.is_size else p.grid[0] for p in effect.parameters}
        for specimen in specimens:
            later = replace(specimen, time=specimen.time + 5000.0)
            here, there = (predicted(s, effect, high) for s in (specimen, later))
            np.testing.assert_allclose(there, here, rtol=1e-6, atol=1e-8, err_msg=effect.name)


@pytest.mark.parametrize("end", ["low", "nominal"])
@pytest.mark.parametrize("name", OF_SIZE)
def test_what_a_record_does_later_changes_nothing_before(name, end, specimens, known):
    effect = known[name]
    values = {p.name: getattr(p, end) if p.is_size else p.grid[0] for p in effect.parameters}
    for specimen in homogeneous() if name == "compressible_foam" else specimens:
        for n in (len(specimen.time) // 20, len(specimen.time) // 2):
            first, whole = (predicted(s, effect, values) for s in (specimen.until(n), specimen))
            kept = np.flatnonzero(specimen.time <= specimen.time[n - 1] - AHEAD)
            np.testing.assert_allclose(first[kept], whole[kept], atol=1e-4 * np.abs(whole).max())


@pytest.mark.parametrize("nu", [0.49, 0.47])
def test_effects_on_constants_depart_from_those_of_the_model(nu, specimens):
    solid = OgdenMaterial((1.0, 1.0), (-4.0, 10.0), nu)
    known = library(solid)
    exponents, ratio = known["ogden_exponents"], known["poisson_ratio"]
    assert [p.neutral for p in exponents.parameters] == [-4.0, 10.0]
    assert set(known) == set(EFFECTS)
    steps = {
        "poisson_0.02_less": (ratio, {"nu": nu - 0.02}),
        "poisson_0.09_less": (ratio, {"nu": nu - 0.09}),
    }
    for specimen in (s for s in specimens if s.elastic.laws):
        laws = replace(specimen.elastic.laws, alpha=solid.alpha, poisson_ratio=nu)
        elastic = replace(specimen.elastic, poisson_ratio=nu, laws=laws)
        specimen = replace(specimen, elastic=elastic)
        for variant, (effect, values) in steps.items():
            change = effect.elastic(specimen, 0.6, specimen.travel, values)
            own = specimen.elastic.change_per_mu(variant, 0.6, specimen.travel)
            np.testing.assert_allclose(change, own, rtol=1e-6, atol=1e-12)
        for effect in (exponents, ratio):
            change = effect.elastic(specimen, 0.6, specimen.travel, effect.neutral())
            assert np.all(change == 0.0)


def test_a_model_has_each_effect_once_one_law_and_what_a_law_has_of_its_own_not_again():
    foam, ratio = EFFECTS["compressible_foam"], EFFECTS["poisson_ratio"]
    for model, admitted in (
        (Model(), set(EFFECTS)),
        (Model((EFFECTS["gain"],)), set(EFFECTS) - {"gain"}),
        (Model((ratio,)), set(EFFECTS) - {"poisson_ratio", "compressible_foam"}),
        (
            Model((EFFECTS["gain"], foam)),
            {name for name, effect in EFFECTS.items() if not effect.is_law}
            - {"gain", "poisson_ratio"},
        ),
    ):
        assert {name for name, effect in EFFECTS.items() if model.admits(effect)} == admitted
    assert Model((EFFECTS["gain"], foam)).law == Model((foam,))
    for effect in EFFECTS.values():
        assert set(effect.has) <= set(EFFECTS)


def test_only_parts_of_a_whole_and_poissons_ratio_may_lie_at_an_end():
    """What lies at an end of a plausible range, as an exponent, wants to be elsewhere."""
    at_ends = {p.name for effect in library().values() for p in effect.parameters if p.limits}
    assert at_ends == {"share", "nu"}


def test_the_library_without_a_solid_is_that_of_the_study():
    for name, effect in library(SOLID).items():
        assert effect.parameters == EFFECTS[name].parameters


def test_the_page_of_the_effects_is_what_the_library_says():
    page = (ROOT / "docs/effects.md").read_text(encoding="utf-8")
    assert page == effects_page.page(), "stale: run python benchmarks/effects_page.py"


def test_the_page_of_the_effects_lists_every_effect_and_parameter():
    page = effects_page.page()
    for effect in EFFECTS.values():
        assert f"\n## `{effect.name}`" in page
        for p in effect.parameters:
            assert f"`{p.name}`" in page.split("\n## ")[0]
