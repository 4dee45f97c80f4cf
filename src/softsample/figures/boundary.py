"""Figure 3: what holds and moves the samples."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from string import ascii_lowercase

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from scipy.spatial import ConvexHull

from softsample.arrays import Array, Ids
from softsample.figures.render import Look, Renderer, draw_surface
from softsample.figures.style import MODE_COLOURS, PALETTE, label_panel, page_figure, styled
from softsample.figures.surface import OBLIQUE, mesh_surface
from softsample.meshing.mesh import HexMesh, face_vectors
from softsample.protocol import DIRECTIONS, PRESSED_MODES
from softsample.shapes import Indenter
from softsample.units import MM
from softsample.wording import spoken

BASE, GLUED = PALETTE[0], PALETTE[1]
PLATEN_MARGIN_MM, ARROW_MM, LIFT_MM = 1.5, 6.0, 2.5

GEOMETRY_NAMES = {"real": "real", "ideal": "idealised"}


@dataclass(frozen=True, eq=False)
class HeldSample:
    """A mesh and the nodes that are held.

    Parameters
    ----------
    sample, mode, geometry : str
        Name, loading, `real` or `ideal`.
    mesh : HexMesh
        Points [m].
    glued : (n,) int64
        Nodes that the moving platen is glued to; not used where it presses.
    indenter : Indenter, optional
        What comes down in place of a platen.
    """

    sample: str
    mode: str
    geometry: str
    mesh: HexMesh
    glued: Ids
    indenter: Indenter | None = None


@styled
def boundary_figure(samples: Sequence[HeldSample], renderer: Renderer) -> Figure:
    """Meshes with the nodes that are fixed and those that the platen moves.

    Parameters
    ----------
    samples
        One a geometry, which is a row, and loading, a column; a pair that is not there is left
        blank.
    """
    there = {(held.geometry, held.mode): held for held in samples}
    rows = [name for name in GEOMETRY_NAMES if name in {geometry for geometry, _ in there}]
    modes = [name for name in MODE_COLOURS if name in {mode for _, mode in there}]
    figure = page_figure(height_mm=16.0 + 48.0 * len(rows))
    axes = figure.subplots(len(rows), len(modes), squeeze=False)
    shown = [held.mesh.points / MM for held in samples]
    shown += [_outline(held.indenter, held.mesh) for held in samples if held.indenter]
    page = OBLIQUE.project(np.concatenate(shown))
    low, high = page.min(axis=0) - 2.0 * PLATEN_MARGIN_MM, page.max(axis=0) + 2.0 * PLATEN_MARGIN_MM
    letters = iter(ascii_lowercase)
    for ax, place in zip(axes.flat, product(rows, modes), strict=True):
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1] + ARROW_MM - LIFT_MM))
        ax.set_axis_off()
        if held := there.get(place):
            mode = spoken(held.mode).capitalize()
            head = f"{mode}, {held.sample}, {GEOMETRY_NAMES[held.geometry]}"
            label_panel(ax, next(letters), head)
            _draw(ax, held, renderer)
    figure.legend(handles=_keys(), loc="outside lower center", ncols=4)
    return figure


def _draw(ax: Axes, held: HeldSample, renderer: Renderer) -> None:
    mesh = held.mesh
    draw_surface(ax, mesh_surface(mesh), OBLIQUE, Look(), renderer)
    seen = _seen_nodes(mesh)
    _dots(ax, mesh.points[np.intersect1d(seen, mesh.bottom)], BASE)
    if held.mode not in PRESSED_MODES:
        _dots(ax, mesh.points[np.intersect1d(seen, held.glued)], GLUED)
    else:
        _draw_rigid(ax, _platen(mesh) if held.indenter is None else _outline(held.indenter, mesh))
    direction = np.array(DIRECTIONS[held.mode])
    lift = LIFT_MM if held.indenter is None else 2.0 * held.indenter.radius / MM
    middle = np.array([0.0, 0.0, mesh.highest / MM + lift])
    back = 0.5 * direction[0] + max(-direction[2], 0.0)  # the tip, middle or tail over the sample
    start = middle - back * ARROW_MM * direction
    tail, tip = OBLIQUE.project(np.array([start, start + ARROW_MM * direction]))
    bend = "arc3,rad=-0.6" if held.mode == "torsion" else "arc3"
    arrow = {"arrowstyle": "-|>", "lw": 1.6, "color": "black", "connectionstyle": bend}
    ax.annotate("", tip, tail, arrowprops=arrow, zorder=6)


def _seen_nodes(mesh: HexMesh) -> Ids:
    """Nodes of the faces that are turned to the eye."""
    normal = face_vectors(mesh.points, mesh.boundary_quads)
    return np.unique(mesh.boundary_quads[normal @ OBLIQUE.towards_eye > 0.0])


def _dots(ax: Axes, points: Array, colour: str) -> None:
    page = OBLIQUE.project(points / MM)
    ax.scatter(page[:, 0], page[:, 1], s=1.2, color=colour, lw=0, zorder=4, rasterized=True)


def _draw_rigid(ax: Axes, points: Array) -> None:
    """What presses on a sample: the outline of points (n, 3) [mm] on the page."""
    page = OBLIQUE.project(points)
    outline = page[ConvexHull(page).vertices]
    ax.add_patch(Polygon(outline, facecolor="0.5", alpha=0.35, edgecolor="0.3", lw=0.6, zorder=5))


def _platen(mesh: HexMesh) -> Array:
    """Corners of the rigid platen at the start, at the highest point."""
    points = mesh.points / MM
    low, high = points.min(axis=0) - PLATEN_MARGIN_MM, points.max(axis=0) + PLATEN_MARGIN_MM
    return np.array(
        [(x, y, mesh.highest / MM) for x in (low[0], high[0]) for y in (low[1], high[1])]
    )


def _outline(indenter: Indenter, mesh: HexMesh) -> Array:
    """Points on the surface of an indenter at the start, as high as it is wide."""
    around, up = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 60), np.linspace(-1.0, 1.0, 41))
    across = np.sqrt(1.0 - up**2) if indenter.kind == "sphere" else np.ones_like(up)
    unit = np.stack([across * np.cos(around), across * np.sin(around), 1.0 + up], axis=-1)
    at_start = unit.reshape(-1, 3) * indenter.radius / MM
    return np.asarray(at_start + np.array([0.0, 0.0, mesh.highest / MM]))


def _keys() -> list[Line2D | Patch]:
    """Legend."""
    dots = {"ls": "", "marker": "o", "ms": 3.5, "mew": 0}
    return [
        Line2D([], [], color=BASE, label="base", **dots),  # type: ignore[arg-type]
        Line2D([], [], color=GLUED, label="bonded, moves with the platen", **dots),  # type: ignore[arg-type]
        Patch(facecolor="0.5", alpha=0.35, edgecolor="0.3", label="rigid platen or indenter"),
        Line2D([], [], color="black", marker=">", ms=3.5, label="displacement"),
    ]
