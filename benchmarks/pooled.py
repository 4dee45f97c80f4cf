"""Records of one synthetic material in torsion, indentation and compression, by independent means.

Torsion is Rivlin's integral; the others are axisymmetric finite elements of felupe with bonded
ends. Run it to write the records of tests/data/pooled.
"""

from pathlib import Path

import felupe as fem
import numpy as np
import pandas as pd

from peers import IsochoricOgden, symmetric_superlu
from softsample.arrays import Array
from softsample.constitutive.ogden import OgdenMaterial

RADIUS, HEIGHT, PUNCH = 10e-3, 10e-3, 4e-3
"""Of the cylinders and of the punch [m]."""

MATERIAL = OgdenMaterial((540.0, 360.0), (-8.0, 16.0), 0.49)
ALONG_RADIUS, POINTS, NOISE, SPEED = 40, 40, 0.003, 0.05e-3
"""Elements, points of a record, standard deviation over the peak, speed of the platen [m/s]."""

TARGET = Path(__file__).parents[1] / "tests/data/pooled"


def torque(angle: Array) -> Array:
    """Torque [N m] of an incompressible cylinder turned by angles (n,) [rad].

    Each ring is in simple shear. R. S. Rivlin 1949, doi:10.1098/rsta.1949.0009.
    """
    place, weight = np.polynomial.legendre.leggauss(40)
    r = 0.5 * RADIUS * (place + 1.0)
    shear = np.multiply.outer(angle, r) / HEIGHT
    stretch = 0.5 * shear + np.sqrt(1.0 + 0.25 * shear**2)
    terms = zip(MATERIAL.mu, MATERIAL.alpha, strict=True)
    stress = sum(2.0 * mu / a * (stretch**a - stretch**-a) for mu, a in terms)
    stress = stress / (stretch + 1.0 / stretch)
    return np.asarray(2.0 * np.pi * stress @ (0.5 * RADIUS * weight * r**2))


def pressed(radius: float, depth: float) -> tuple[Array, Array]:
    """Depth [m] and force [N] where the top is pushed in without slip out to a radius [m]."""
    mesh = fem.Rectangle(b=(HEIGHT, RADIUS), n=(ALONG_RADIUS + 1, ALONG_RADIUS + 1))
    field = fem.FieldContainer([fem.FieldAxisymmetric(fem.RegionQuad(mesh), dim=2)])
    solid = fem.SolidBodyNearlyIncompressible(
        IsochoricOgden(MATERIAL), field, bulk=MATERIAL.bulk_modulus
    )
    z, r = mesh.points.T
    top = np.isclose(z, HEIGHT) & (r < radius * (1.0 + 1e-9))
    bounds = {
        "base": fem.Boundary(field[0], mask=np.isclose(z, 0.0)),
        "axis": fem.Boundary(field[0], mask=np.isclose(r, 0.0), skip=(1, 0)),
        "down": fem.Boundary(field[0], mask=top, skip=(0, 1)),
        "held": fem.Boundary(field[0], mask=top, skip=(1, 0)),
    }
    depths, forces = np.linspace(0.0, depth, 21), [0.0]
    for at in depths[1:]:
        bounds["down"].value = -at
        dof0, dof1 = fem.dof.partition(field, bounds)
        ext0 = fem.dof.apply(field, bounds, dof0)
        found = fem.newtonraphson(
            items=[solid], dof0=dof0, dof1=dof1, ext0=ext0, solver=symmetric_superlu, tol=1e-6,
            verbose=0,
        )  # fmt: skip
        forces.append(float(abs(fem.tools.force(field, found.fun, bounds["down"])[0])))
    return depths, np.array(forces)


def records() -> dict[str, pd.DataFrame]:
    """Records by test: pushing is negative."""
    rng = np.random.default_rng(7)
    part = np.linspace(0.0, 1.0, POINTS)

    def noisy(force: Array) -> Array:
        return force + NOISE * np.abs(force).max() * rng.standard_normal(POINTS)

    angle = 0.3 * HEIGHT / RADIUS * part
    found = {
        "torsion": pd.DataFrame({
            "time_s": angle * RADIUS / SPEED, "angle_deg": np.degrees(angle),
            "torque_Nmm": 1e3 * noisy(torque(angle)),
        })
    }  # fmt: skip
    for name, radius, depth in (("indentation", PUNCH, 1e-3), ("compression", RADIUS, 1.5e-3)):
        way, force = pressed(radius, depth)
        at = depth * part
        found[name] = pd.DataFrame({
            "time_s": at / SPEED, "displacement_mm": -1e3 * at,
            "force_N": -noisy(np.interp(at, way, force)),
        })  # fmt: skip
    return found


if __name__ == "__main__":
    TARGET.mkdir(parents=True, exist_ok=True)
    for name, table in records().items():
        table.round(6).to_csv(TARGET / f"{name}.csv", index=False)
