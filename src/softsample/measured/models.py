"""Models of ideal shapes: force per modulus of all mixtures, and how it changes with the model."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.calibration.curves import CurveFamily
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import SolverSettings
from softsample.fem.family import FamilySettings, family_fractions
from softsample.loop.changes import for_all_mixtures
from softsample.loop.inputs import MechanicalTest, MeshedSample, VariantSettings
from softsample.loop.specimen import Elastic
from softsample.loop.variants import (
    MARGIN,
    simulate_variants,
    wanted_force,
)
from softsample.measured.homogeneous import force_per_mu, normal_per_mu
from softsample.measured.measurement import Measurement, Shape
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.cylinder import mesh_cylinder
from softsample.meshing.mesh import HexMesh

Array = NDArray[np.float64]
Key = tuple[str, str, str, str]

MM = 1e-3
POISSON = 0.49
MIXTURE = 0.5
"""Mixture at which the changes of the model are simulated."""
POINTS = 61
HEIGHT = 13e-3
"""Height [m] of the samples that the solver's loading time is set for."""


@dataclass(frozen=True)
class ModelSettings:
    """How the ideal shapes of a set are modelled; mirrors a set's keys in config `measured:`.

    Parameters
    ----------
    alpha : tuple of float
        Exponents of the two Ogden terms.
    kinds : tuple of str
        `bonded`: finite elements that stick to both platens; `homogeneous`: closed form.
    reach : float
        Largest nominal strain, or amount of shear, that is used.
    elements : int
        Elements along the shortest edge, at least.
    """

    alpha: tuple[float, float]
    kinds: tuple[str, ...] = ("bonded",)
    reach: float = 0.5
    elements: int = 8


def key_of(kind: str, test: Measurement, channel: str) -> Key:
    """What a model belongs to: its kind, the shape in mm, the mode, the channel of force."""
    edges = (test.shape.length, test.shape.width, test.shape.height)
    size = "x".join(f"{edge / MM:g}" for edge in edges)
    return kind, f"{test.shape.kind}_{size}", test.mode, channel


def model_table(
    tests: Iterable[Measurement], settings: ModelSettings, solver: SolverSettings
) -> pd.DataFrame:
    """Curves of all models that the tests of a set need.

    Returns
    -------
    DataFrame
        `kind`, `shape`, `mode`, `channel` (`force`, `force_normal`), `curve` (a mixture as a
        number, or the name of a change), `displacement_mm` along the loading, `area_mm2` = force,
        or change of the force, over shear modulus.
    """
    parts, done = [], set()
    for test in tests:
        channels = ["force"] if test.record.force_normal is None else ["force", "force_normal"]
        for kind in settings.kinds:
            for channel in channels:
                key = key_of(kind, test, channel)
                if key not in done:
                    done.add(key)
                    parts += list(_rows(key, test, settings, solver))
    return pd.concat(parts, ignore_index=True)


def _rows(
    key: Key, test: Measurement, settings: ModelSettings, solver: SolverSettings
) -> Iterator[pd.DataFrame]:
    kind, shape, mode, channel = key
    curves = _bonded if kind == "bonded" else _homogeneous
    travel, found = curves(test.shape, mode, channel == "force_normal", settings, solver)
    for name, area in found.items():
        yield pd.DataFrame(
            {
                "kind": kind, "shape": shape, "mode": mode, "channel": channel, "curve": name,
                "displacement_mm": travel / MM, "area_mm2": area / MM**2,
            }
        )  # fmt: skip


def _homogeneous(
    shape: Shape, mode: str, normal: bool, settings: ModelSettings, solver: SolverSettings
) -> tuple[Array, dict[str, Array]]:
    """Curves in closed form; of the changes only those of the exponents are defined."""
    travel = np.linspace(0.0, MARGIN * settings.reach * shape.height, POINTS)

    def curve(mixture: float, alpha: tuple[float, float]) -> Array:
        if normal:
            return normal_per_mu(shape, mixture, alpha, travel)
        return force_per_mu(shape, mode, mixture, alpha, travel)

    (first, second), step = settings.alpha, VariantSettings().exponent
    plain = curve(MIXTURE, settings.alpha)
    found = {str(r): curve(r, settings.alpha) for r in family_fractions(FamilySettings())}
    found["alpha1"] = curve(MIXTURE, (first + step, second)) - plain
    found["alpha2"] = curve(MIXTURE, (first, second + step)) - plain
    return travel, found


def _bonded(
    shape: Shape, mode: str, normal: bool, settings: ModelSettings, solver: SolverSettings
) -> tuple[Array, dict[str, Array]]:
    """Curves and changes by finite elements; waves cross a small shape in less time."""
    variants = VariantSettings()
    solver = replace(solver, loading_time_s=solver.loading_time_s * shape.height / HEIGHT)

    def mesh_shifted(shift: float) -> MeshedSample:
        mesh = _mesh(shape, settings.elements, shift)
        return MeshedSample(mesh, mesh.glued(0.0))

    modulus, reach = solver.reference_modulus_pa, settings.reach * shape.height
    solid = unit_modulus(MIXTURE, settings.alpha, POISSON, modulus)
    test = MechanicalTest(mode, solid, reach, ContactSettings(), solver, variants)
    travel, changes = simulate_variants(mesh_shifted, test, normal=normal)
    sample = mesh_shifted(0.0)
    held = mode_boundary(sample.mesh, mode, sample.glued, ContactSettings())
    model = sample.model(solver)
    found = dict(changes)
    for r in map(float, family_fractions(FamilySettings())):
        run = model.run(unit_modulus(r, settings.alpha, POISSON, modulus), held, MARGIN * reach)
        force = wanted_force(run, normal) / modulus
        found[str(r)] = np.interp(travel, run.displacement, force)
    return travel, found


def _mesh(shape: Shape, elements: int, shift: float) -> HexMesh:
    """Mesh of a shape with its free faces moved out by a length [m]; the base stays."""
    grown = replace(
        shape,
        length=shape.length + 2.0 * shift,
        width=shape.width + 2.0 * shift,
        height=shape.height + shift,
    )
    size = min(shape.length, shape.width, shape.height) / elements
    if shape.kind == "cylinder":
        return mesh_cylinder(grown.length, grown.height, size)
    return mesh_cuboid(grown.length, grown.width, grown.height, size)


def elastics(table: pd.DataFrame) -> dict[Key, Elastic]:
    """The models of a table by what they belong to."""
    found = {}
    for key, rows in table.groupby(["kind", "shape", "mode", "channel"], sort=False):
        by_curve = rows.groupby("curve", sort=False)
        curves = {str(name): MM**2 * part["area_mm2"].to_numpy() for name, part in by_curve}
        travel = MM * np.unique(rows["displacement_mm"])
        mixtures = sorted((name for name in curves if name[0].isdigit()), key=float)
        family = CurveFamily(
            np.array([float(r) for r in mixtures]),
            travel,
            np.stack([curves.pop(r) for r in mixtures]),
        )
        kind, shape, mode, channel = map(str, key)
        changes: Mapping[str, CurveFamily | Array] = curves
        if kind == "bonded" and channel == "force":
            changes = for_all_mixtures(curves, family, MIXTURE)
        found[kind, shape, mode, channel] = Elastic(family, changes, mode == "compression", POISSON)
    for (kind, shape, mode, channel), elastic in list(found.items()):
        sticking = found.get(("bonded", shape, mode, channel))
        if kind == "homogeneous" and mode == "compression" and sticking is not None:
            slip = _slip(elastic.family, sticking.family)
            changed = replace(elastic, variants={**elastic.variants, "platen_slip": slip})
            found[kind, shape, mode, channel] = changed
    return found


def _slip(free: CurveFamily, sticking: CurveFamily) -> Array:
    """Change of the force per modulus (n,) [m2] from sticking to sliding ends."""
    stuck = np.interp(free.displacement, sticking.displacement, sticking.curve(MIXTURE))
    return free.curve(MIXTURE) - stuck
