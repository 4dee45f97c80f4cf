"""Figure 7: deformed samples with their largest principal strain."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from string import ascii_lowercase
from typing import Self

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from softsample.arrays import Array, Ids
from softsample.figures.render import Look, Renderer, draw_surface
from softsample.figures.style import PAGE_WIDTH_MM, STRAIN_MAP, label_panel, page_figure, styled
from softsample.figures.surface import FRONT, Surface, mesh_surface, silhouette
from softsample.meshing.mesh import HexMesh
from softsample.shapes import Indenter
from softsample.units import MM
from softsample.wording import spoken

Fields = tuple[HexMesh, Mapping[str, Array], Mapping[str, Array]]
"""Mesh [m], node data and element data of a run, as its `fields` file has them."""

PANELS = ("surface", "real", "ideal")
ALONE_WIDTH_MM = 130.0
"""Width of a figure of ideal shapes alone."""

PLATEN_MM = 1.0
PANEL_MM, TITLE_MM = 46.0, 9.0
"""Width of a panel and height of its title on the page."""

PERCENTILE = 99.0
"""Of the values in view, at which the colour bar ends; what is beyond has its last colour."""


@dataclass(frozen=True)
class Deformed:
    """One geometry before and after loading.

    Parameters
    ----------
    before, after : Surface
        Boundary of the mesh; `after` has the largest principal Hencky strain as values.
    """

    before: Surface
    after: Surface

    @classmethod
    def of_fields(
        cls,
        mesh: HexMesh,
        points: Mapping[str, Array],
        cells: Mapping[str, Array],
        cut: bool = False,
    ) -> Self:
        """Surfaces of a run, of the half behind the plane y = 0 alone if it is to be cut there."""
        strain = cells["max_principal_hencky_strain"]
        if cut:
            behind = mesh.points[mesh.hexes].mean(axis=1)[:, 1] > -1e-6 * mesh.edge_length
            mesh, strain = HexMesh(mesh.points, mesh.hexes[behind]), strain[behind]
        return cls(mesh_surface(mesh), mesh_surface(mesh, points["displacement_mm"], strain))


def moved_surface(*fields: *Fields) -> tuple[Array, Array, Ids, Array]:
    """Points [mm] before and after a run, faces, and strain there; from its `fields` file."""
    shape = Deformed.of_fields(*fields)
    values = shape.after.values
    assert values is not None  # of a run
    return shape.before.points, shape.after.points, shape.after.faces, values


@dataclass(frozen=True)
class StrainRow:
    """One sample: a row of the figure.

    Parameters
    ----------
    sample, mode : str
        Name and loading.
    strain : float
        Nominal strain at the end: travel over the height of the ideal shape, positive.
    surface : Surface or None
        The sample's surface before the test, where it is known.
    shapes : mapping of Deformed
        By geometry, `ideal` or both.
    indenter : Indenter, optional
        What comes down on the sample in place of a platen.
    tip_mm : float
        Height of its lowest point at the end [mm].
    """

    sample: str
    mode: str
    strain: float
    surface: Surface | None
    shapes: Mapping[str, Deformed]
    indenter: Indenter | None = None
    tip_mm: float = 0.0

    @classmethod
    def of(
        cls,
        row: Mapping[str, str],
        surface: Surface | None,
        runs: Mapping[str, Fields],
        travel_mm: float,
        height_mm: float,
    ) -> Self:
        """From a row of the study table with its defaults, and the fields of a run by geometry.

        Travel of the platen and height of the ideal shape are in mm.
        """
        indenter = Indenter.of_row(row)
        shapes = {k: Deformed.of_fields(*run, cut=indenter is not None) for k, run in runs.items()}
        strain, tip = travel_mm / height_mm, height_mm - travel_mm
        return cls(row["sample"], row["mode"], strain, surface, shapes, indenter, tip)


@styled
def strain_figure(rows: Sequence[StrainRow], renderer: Renderer = "vtk") -> Figure:
    """Front views: sample before the test, strain on the real and on the idealised geometry.

    Parameters
    ----------
    rows
        One a loading mode. Panels of a surface and a real geometry that are not known stay empty;
        they are left out if no row has any.
    """
    frames = [_frame(row) for row in rows]
    heights = [TITLE_MM + PANEL_MM * float(np.divide(*(high - low)[::-1])) for low, high in frames]
    known = any("real" in row.shapes for row in rows)
    panels = PANELS if known else PANELS[-1:]
    figure = page_figure(14.0 + sum(heights), PAGE_WIDTH_MM if known else ALONE_WIDTH_MM)
    axes = figure.subplots(len(rows), len(panels), squeeze=False, height_ratios=heights)
    letters = count()
    for row, line, frame in zip(rows, axes, frames, strict=True):
        heads = _heads(row)
        for ax, panel in zip(line, panels, strict=True):
            ax.set(xlim=(frame[0][0], frame[1][0]), ylim=(frame[0][1], frame[1][1]))
            if panel in heads:
                label_panel(ax, ascii_lowercase[next(letters)], heads[panel])
            else:
                ax.set_axis_off()
        _draw_row(dict(zip(panels, line, strict=True)), row, renderer)
    for ax in axes[-1]:
        ax.set_xlabel("x [mm]")
    return figure


def _heads(row: StrainRow) -> dict[str, str]:
    """Titles of the panels that a row has."""
    mode, strain = spoken(row.mode).capitalize(), f"nominal strain {row.strain:.2f}"
    heads = {"surface": f"{mode}, {row.sample}", "real": f"Real, {strain}"}
    if "real" not in row.shapes:
        return {"ideal": f"{mode}, {row.sample}: {strain}"}
    return heads | {"ideal": f"Idealised, {strain}"}


def _draw_row(line: Mapping[str, Axes], row: StrainRow, renderer: Renderer) -> None:
    """Front views of one sample and the colour bar of the row."""
    limits = _limits(row)
    if row.surface is not None:
        draw_surface(line["surface"], row.surface, FRONT, Look(), renderer)
        _draw_platens(line["surface"], row.surface)
    for geometry, shape in row.shapes.items():
        ax = line[geometry]
        draw_surface(ax, shape.after, FRONT, Look(limits=limits), renderer)
        if row.indenter is None:
            _draw_platens(ax, shape.after)
        else:
            _draw_indenter(ax, row.indenter, row.tip_mm)
        outline = silhouette(shape.before, FRONT)
        ax.plot(outline[:, 0], outline[:, 1], color="black", lw=0.7, ls=(0, (4, 2)), zorder=3)
    line["surface" if row.surface is not None else "ideal"].set_ylabel("z [mm]")
    last = line["ideal"]
    last.figure.colorbar(
        ScalarMappable(Normalize(*limits), colormaps[STRAIN_MAP]),
        cax=last.inset_axes((1.05, 0.0, 0.05, 1.0)),
        label="Max. principal\nHencky strain [–]",
        extend="max",
    )


def _limits(row: StrainRow) -> tuple[float, float]:
    """Common ends of the colour bar of a row, from the faces turned to the reader."""
    values = np.concatenate([_seen_values(shape.after) for shape in row.shapes.values()])
    return 0.0, float(np.percentile(values, PERCENTILE))


def _seen_values(surface: Surface) -> Array:
    """Mean values of the faces that the front view shows."""
    if surface.values is None:
        return np.empty(0)
    corners = FRONT.project(surface.points)[surface.faces]
    a, b = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
    seen = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 0.0
    return np.asarray(surface.values[surface.faces[seen]].mean(axis=1))


def _frame(row: StrainRow) -> tuple[Array, Array]:
    """Lower and upper corner of a page that holds all shapes and platens of a row [mm]."""
    shapes = [surface for shape in row.shapes.values() for surface in (shape.before, shape.after)]
    shapes += [row.surface] if row.surface is not None else []
    page = np.concatenate([FRONT.project(surface.points) for surface in shapes])
    margin = np.array([1.0, PLATEN_MM + 0.5])
    return page.min(axis=0) - margin, page.max(axis=0) + margin


def _draw_platens(ax: Axes, surface: Surface) -> None:
    """Base and moving platen as grey bars that cover the sample; the moving one touches its top."""
    x, z = surface.points[:, 0], surface.points[:, 2]
    top = float(z.max())
    for part, at in ((x[z <= 0.5 * top], -PLATEN_MM), (x[z >= 0.5 * top], top)):
        low, high = float(part.min()) - 0.5, float(part.max()) + 0.5
        ax.add_patch(Rectangle((low, at), high - low, PLATEN_MM, color="0.6", lw=0, zorder=1))


def _draw_indenter(ax: Axes, indenter: Indenter, tip_mm: float) -> None:
    """An indenter above its lowest point, as far as the frame shows it."""
    radius = indenter.radius / MM
    if indenter.kind == "sphere":
        ax.add_patch(Circle((0.0, tip_mm + radius), radius, color="0.6", lw=0, zorder=1))
    else:
        ax.add_patch(Rectangle((-radius, tip_mm), 2.0 * radius, 2.0 * radius, color="0.6", lw=0,
                               zorder=1))  # fmt: skip
