"""Changes of the force by effects at given sizes, each a run of the changed model."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from softsample.arrays import Array
from softsample.constitutive.material import Material, Term
from softsample.constitutive.ogden import Fibres, OgdenMaterial
from softsample.fem.boundary import Boundary, platen_boundary
from softsample.response.perturbations import MARGIN, changed_boundaries
from softsample.response.pieces import MechanicalTest, MeshedSample
from softsample.response.unit import paced

Values = Mapping[str, float]
Runs = list[tuple[float, Material, Boundary]]


def at_size(name: str) -> str:
    """Name of the variant that is an effect simulated at its size."""
    return f"at_size_{name}"


def simulate_sizes(
    mesh_shifted: Callable[[float], MeshedSample], test: MechanicalTest, sizes: Mapping[str, Values]
) -> tuple[Array, dict[str, Array]]:
    """Change of the force per modulus by each effect at its size.

    Parameters
    ----------
    mesh_shifted, test
        As of `softsample.response.perturbations.simulate_perturbations`.
    sizes : mapping
        Values of the parameters by effect, of those that act in this mode.

    Returns
    -------
    displacement : (n,) float64
        Travels [m].
    changes : dict of (n,) float64
        Change of the force along the travel per shear modulus [m2] by effect.
    """
    material, reach = test.material, MARGIN * test.travel
    sample = mesh_shifted(0.0)
    model = sample.model(test.solver)
    held = test.held(sample)
    pace = paced(model, material, held, reach)
    changes = {}
    for name, values in sizes.items():
        if name == "boundary_shift":
            larger = mesh_shifted(1e-3 * values["shift_mm"])
            on = larger.model(test.solver)
            runs = [(1.0, material, test.held(larger))]
        else:
            on, runs = model, _runs(name, values, sample, test, held)
        change = sum(
            weight
            * (on.run(of, hold, reach, loading_time=pace.loading_time).force - pace.run.force)
            for weight, of, hold in runs
        )
        changes[name] = np.asarray(change / material.shear_modulus)
    return pace.run.displacement, changes


def _runs(
    name: str, values: Values, sample: MeshedSample, test: MechanicalTest, held: Boundary
) -> Runs:
    """Weights, materials and boundaries of the runs that make up an effect at its sizes."""
    material = test.material
    if name == "poisson_ratio":
        return [(1.0, replace(material, poisson_ratio=values["nu"]), held)]
    if name == "ogden_exponents":
        alpha = values["alpha1"], values["alpha2"]
        return [(1.0, OgdenMaterial(material.mu, alpha, material.poisson_ratio), held)]
    if name == "elastic_law":
        one = OgdenMaterial((material.shear_modulus,), (values["alpha"],), material.poisson_ratio)
        return [(values["share"], one, held)]
    if name == "compressible_foam":
        foam = Term("foam", material.shear_modulus, (values["alpha"], values["nu"]))
        return [(values["share"], Material((foam,), values["nu"]), held)]
    if name == "anisotropy":
        angle = np.radians(values["angle_deg"])
        along = float(np.sin(angle)), 0.0, float(np.cos(angle))
        fibres = Fibres(values["k1"] * material.shear_modulus, along)
        return [(1.0, material.plus(fibres), held)]
    if name == "platen_tilt":
        axis, tilt = np.radians(values["axis_deg"]), values["tilt_deg"]
        tilts = (float(tilt * np.cos(axis)), float(tilt * np.sin(axis)))
        return [(1.0, material, platen_boundary(sample.mesh, test.platen_contact, tilt_deg=tilts))]
    side, steps = values["side"], replace(test.steps, missing_bond=values["missing"])
    weights = {
        "partial_bond_ahead": max(side, 0.0),
        "partial_bond_behind": max(-side, 0.0),
        "partial_bond_beside": 1.0 - abs(side),
    }
    boundaries = changed_boundaries(sample, replace(test, steps=steps))
    return [
        (weight, material, boundaries[variant])
        for variant, weight in weights.items()
        if weight > 0.0 and variant in boundaries
    ]
