"""Figure 7: deformed samples with their largest principal strain."""

from collections.abc import Sequence
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
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from softsample.figures.render import Look, Renderer, draw_surface
from softsample.figures.style import MODE_NAMES, STRAIN_MAP, label_panel, page_figure, styled
from softsample.figures.surface import FRONT, Surface, mesh_surface, silhouette
from softsample.meshing.mesh import HexMesh

Array = NDArray[np.float64]

PLATEN_MM = 1.0
PANEL_MM, TITLE_MM = 46.0, 9.0
"""Width of a panel and height of its title on the page."""

PERCENTILES = (1.0, 99.0)
"""Share of the surface values that the colour bar spans; what is beyond has its end colours."""


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
    def of_run(cls, mesh: HexMesh, displacement_mm: Array, strain: Array) -> Self:
        """Surfaces of a run: nodal displacement (n_nodes, 3), strain of elements (n_elements,)."""
        return cls(mesh_surface(mesh), mesh_surface(mesh, displacement_mm, strain))


@dataclass(frozen=True)
class StrainRow:
    """One sample: a row of the figure.

    Parameters
    ----------
    sample, mode : str
        Name and loading.
    strain : float
        Nominal strain at the end: travel over the height of the cuboid, positive.
    surface : Surface
        Segmented surface before the test.
    real, ideal : Deformed
        Both geometries.
    """

    sample: str
    mode: str
    strain: float
    surface: Surface
    real: Deformed
    ideal: Deformed


@styled
def strain_figure(rows: Sequence[StrainRow], title: str, renderer: Renderer = "vtk") -> Figure:
    """Front views: sample before the test, strain on the real and on the idealised geometry.

    Parameters
    ----------
    rows
        One a loading mode.
    title
        Title of the figure.
    renderer
        `vtk` or `matplotlib`.
    """
    frames = [_frame(row) for row in rows]
    heights = [TITLE_MM + PANEL_MM * float(np.divide(*(high - low)[::-1])) for low, high in frames]
    figure = page_figure(height_mm=14.0 + sum(heights))
    axes = figure.subplots(len(rows), 3, squeeze=False, height_ratios=heights)
    letters = count()
    for row, line, frame in zip(rows, axes, frames, strict=True):
        heads = (
            f"{MODE_NAMES[row.mode]}, {row.sample}: MRI",
            f"Real, nominal strain {row.strain:.2f}",
            f"Idealised, nominal strain {row.strain:.2f}",
        )
        for ax, head in zip(line, heads, strict=True):
            ax.set(xlim=(frame[0][0], frame[1][0]), ylim=(frame[0][1], frame[1][1]))
            label_panel(ax, ascii_lowercase[next(letters)], head)
        _draw_row(line, row, renderer)
    for ax in axes[-1]:
        ax.set_xlabel("x [mm]")
    figure.suptitle(title)
    return figure


def _draw_row(line: Sequence[Axes], row: StrainRow, renderer: Renderer) -> None:
    """Three front views of one sample and the colour bar of the row."""
    limits = _limits(row)
    draw_surface(line[0], row.surface, FRONT, Look(), renderer)
    _draw_platens(line[0], row.surface)
    for ax, shape in zip(line[1:], (row.real, row.ideal), strict=True):
        draw_surface(ax, shape.after, FRONT, Look(limits=limits), renderer)
        _draw_platens(ax, shape.after)
        outline = silhouette(shape.before, FRONT)
        ax.plot(outline[:, 0], outline[:, 1], color="black", lw=0.7, ls=(0, (4, 2)), zorder=3)
    line[0].set_ylabel("z [mm]")
    line[-1].figure.colorbar(
        ScalarMappable(Normalize(*limits), colormaps[STRAIN_MAP]),
        cax=line[-1].inset_axes((1.05, 0.0, 0.05, 1.0)),
        label="Max. principal\nHencky strain [–]",
        extend="both",
    )


def _limits(row: StrainRow) -> tuple[float, float]:
    """Common ends of the colour bar of a row, from the faces turned to the reader."""
    values = np.concatenate([_seen_values(shape.after) for shape in (row.real, row.ideal)])
    low, high = np.percentile(values, PERCENTILES)
    return max(0.0, float(low)), float(high)


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
    shapes = [row.surface, *(s for g in (row.real, row.ideal) for s in (g.before, g.after))]
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
