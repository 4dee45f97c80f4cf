"""One picture of what each mechanic does to a test of the nominal cuboid; part of `make verify`."""

import sys
from collections.abc import Callable
from dataclasses import replace
from string import ascii_lowercase

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from case import MATERIAL
from softsample.constitutive.material import Relaxation
from softsample.constitutive.ogden import Fibres
from softsample.fem.boundary import Boundary, ContactSettings, glued_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, Gravity, Run, SolverSettings
from softsample.figures.style import PALETTE, label_panel, page_figure, save, styled
from softsample.meshing.bond import partial_bond
from softsample.meshing.cuboid import mesh_cuboid
from softsample.protocol import History

DASHES = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (5, 1.5, 1.2, 1.5)), (0, (9, 2)))
"""Of lines that grey print has to tell apart."""

MESH = mesh_cuboid(23e-3, 20e-3, 13e-3, 1e-3)
SETTINGS = SolverSettings(loading_time_s=0.12)
MODEL = ExplicitModel(MESH, SETTINGS)
STICKY = ContactSettings()
TOP = MESH.glued(0.0)
CYCLE = History(np.array([0.0, 11.0, 71.0, 82.0]), 1e-3 * np.array([0.0, 3.25, 3.25, 0.0]))


def glued(mode: str, nodes: np.ndarray = TOP) -> Boundary:
    """Top bonded, or some of its nodes."""
    return glued_boundary(MESH, mode, nodes)


def curve(axes: Axes, run: Run, label: str, sign: float = 1.0) -> None:
    """Force against displacement, each line with a dash of its own."""
    dash = DASHES[len(axes.lines)]
    axes.plot(1e3 * run.displacement, sign * run.force, ls=dash, label=label)


def friction(axes: Axes) -> None:
    """Compression between platens of growing roughness."""
    for mu in (0.0, 0.1, 0.3, 1.0, None):
        contact = ContactSettings(friction=mu, base_friction=mu)
        label = "no slip, bonded" if mu is None else f"friction {mu}"
        curve(axes, MODEL.run(MATERIAL, platen_boundary(MESH, contact), 2.6e-3), label)


def tilt(axes: Axes) -> None:
    """Compression by a tilted platen."""
    for angle in (0.0, 1.0, 2.0, 4.0):
        boundary = platen_boundary(MESH, STICKY, tilt_deg=(0.0, angle))
        curve(axes, MODEL.run(MATERIAL, boundary, 2.6e-3), f"{angle:g} degrees")


def weight(axes: Axes) -> None:
    """Tension with own weight, bonded before or after settling."""
    for label, gravity in (
        ("no weight", None),
        ("bonded, then settled", Gravity(settle_first=False)),
        ("settled, then bonded", Gravity(settle_first=True)),
    ):
        curve(axes, MODEL.run(MATERIAL, glued("tension"), 2e-3, gravity=gravity), label)


def poisson(axes: Axes) -> None:
    """Compression of ever less compressible samples."""
    for nu in (0.40, 0.45, 0.48, 0.49, 0.499):
        material = replace(MATERIAL, poisson_ratio=nu)
        curve(axes, MODEL.run(material, glued("compression"), 2.6e-3), f"ν = {nu}")


def bond(axes: Axes) -> None:
    """Tension with part of the bond."""
    for share in (1.0, 0.875, 0.6):
        nodes = partial_bond(MESH, TOP, share, (1.0, 0.0)) if share < 1.0 else TOP
        curve(
            axes,
            MODEL.run(MATERIAL, glued("tension", nodes), 3.25e-3),
            f"{100.0 * share:g} % bonded",
        )


def relaxation(axes: Axes) -> None:
    """Ramp, hold and unloading against time."""
    for label, law in (
        ("elastic", None),
        ("g = 0.3, τ = 10 s", Relaxation((0.3,), (10.0,))),
        ("g = 0.3, 0.3, τ = 5, 50 s", Relaxation((0.3, 0.3), (5.0, 50.0))),
    ):
        run = MODEL.run(replace(MATERIAL, relaxation=law), glued("shear"), CYCLE)
        axes.plot(run.time, run.force, ls=DASHES[len(axes.lines)], label=label)


def fibres(axes: Axes) -> None:
    """Shear along and across fibres, and with none."""
    for label, laws in (
        ("none", ()),
        ("along x", (Fibres(400.0, (1.0, 0.0, 0.0)),)),
        ("along y", (Fibres(400.0, (0.0, 1.0, 0.0)),)),
        ("along x + z", (Fibres(400.0, (1.0, 0.0, 1.0)),)),
    ):
        curve(axes, MODEL.run(MATERIAL.plus(*laws), glued("shear"), 3.9e-3), label)


def regions(axes: Axes) -> None:
    """A stiff inclusion, a stiff half."""
    middle = MESH.points[MESH.hexes].mean(axis=1)
    ball = np.linalg.norm(middle - [0.0, 0.0, 6.5e-3], axis=1) < 4e-3
    for label, where in (
        ("uniform", ball & False),
        ("inclusion", ball),
        ("half", middle[:, 0] > 0),
    ):
        model = ExplicitModel(MESH, SETTINGS, np.where(where, 4.0, 1.0))
        curve(axes, model.run(MATERIAL, glued("tension"), 3.25e-3), label)


PANELS: dict[str, Callable[[Axes], None]] = {
    "Coulomb friction, compression": friction,
    "tilted platen, compression": tilt,
    "own weight, tension": weight,
    "Poisson's ratio, compression": poisson,
    "part of the bond, tension": bond,
    "relaxation, shear: ramp, hold, unloading": relaxation,
    "fibres, shear": fibres,
    "regions four times as stiff, tension": regions,
}


@styled
def picture() -> Figure:
    """All panels."""
    figure = page_figure(230.0)
    panels = zip(ascii_lowercase, figure.subplots(4, 2).flat, PANELS.items(), strict=False)
    for letter, axes, (title, draw) in panels:
        axes.set_prop_cycle(color=PALETTE)
        draw(axes)
        label_panel(axes, letter, title)
        axes.set(xlabel="Displacement of the platen [mm]", ylabel="Force [N]")
        if draw is relaxation:
            axes.set(xlabel="Time [s]")
        axes.legend(handlelength=2.6)
    return figure


def main(target: str) -> None:
    """Draw all panels into `target`."""
    save(picture(), target, 160)


if __name__ == "__main__":
    main(sys.argv[1])
