"""Draw surfaces into Matplotlib axes: rendered by VTK where that works, painted elsewhere."""

import logging
from dataclasses import dataclass
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize, to_rgb
from numpy.typing import NDArray

from softsample.arrays import Array
from softsample.figures.offscreen import ADVICE, rendering_works
from softsample.figures.style import IMAGE_DOTS_PER_INCH, MM_PER_INCH, STRAIN_MAP, TISSUE
from softsample.figures.surface import Surface, View

Renderer = Literal["vtk", "matplotlib"]

logger = logging.getLogger(__name__)

AMBIENT, VALUE_AMBIENT = 0.45, 0.85
"""Light from everywhere, the rest from `LIGHT`; more of it where colours are to be read."""

LIGHT = np.array([0.25, 0.45, 0.86])
"""Direction to the light in page coordinates (right, up, towards the eye)."""


@dataclass(frozen=True)
class Look:
    """How a surface is coloured.

    Parameters
    ----------
    colour : str
        Colour of a surface without values.
    limits : (float, float), optional
        Ends of the colour map for a surface with values.
    edges : bool
        Draw the edges of the faces.
    """

    colour: str = TISSUE
    limits: tuple[float, float] | None = None
    edges: bool = False


def available_renderer() -> Renderer:
    """What this machine can draw surfaces with; warns once if it is not VTK."""
    if rendering_works():
        return "vtk"
    logger.warning(ADVICE)
    return "matplotlib"


def draw_surface(
    ax: Axes, surface: Surface, view: View, look: Look, renderer: Renderer = "vtk"
) -> None:
    """Draw a surface in page coordinates [mm]; equal scales, so lengths can be read off.

    Parameters
    ----------
    ax
        Axes; their limits must hold the surface and are not changed.
    renderer
        `vtk` or `matplotlib`; see `available_renderer`.
    """
    ax.set_aspect("equal")
    if renderer == "vtk":
        _draw_rendered(ax, surface, view, look)
    else:
        _draw_painted(ax, surface, view, look)


def _draw_rendered(ax: Axes, surface: Surface, view: View, look: Look) -> None:
    page = view.project(surface.points)
    low, high = page.min(axis=0) - 0.2, page.max(axis=0) + 0.2
    image = render(surface, view, look, low, high)
    ax.imshow(image, extent=(low[0], high[0], low[1], high[1]), interpolation="antialiased",
              zorder=2, aspect="equal")  # fmt: skip


def render(surface: Surface, view: View, look: Look, low: Array, high: Array) -> NDArray[np.uint8]:
    """Image (rows, columns, 4) of the page rectangle from `low` to `high` [mm], by VTK."""
    import pyvista
    from vtkmodules.vtkCommonCore import vtkObject

    vtkObject.GlobalWarningDisplayOff()  # without an X server it would say so, then use EGL
    pixels_per_mm = IMAGE_DOTS_PER_INCH / MM_PER_INCH * 1.6
    size = [int(n) for n in np.ceil((high - low) * pixels_per_mm)]
    count = surface.faces.shape[1]
    faces = np.insert(surface.faces, 0, count, axis=1)
    plotter = pyvista.Plotter(off_screen=True, window_size=size, lighting="none")
    plotter.enable_anti_aliasing("ssaa")
    ambient = AMBIENT if surface.values is None else VALUE_AMBIENT
    options: dict[str, Any] = {"ambient": ambient, "diffuse": 1.0 - ambient}
    if look.edges:
        options |= {"show_edges": True, "edge_color": "#303030", "line_width": 1.2}
    else:
        options |= {"smooth_shading": True, "split_sharp_edges": True}
    if surface.values is None:
        options |= {"color": look.colour}
    else:
        options |= {"scalars": surface.values, "clim": look.limits, "cmap": STRAIN_MAP}
        options |= {"show_scalar_bar": False, "interpolate_before_map": True}
    plotter.add_mesh(pyvista.PolyData(surface.points, faces.ravel()), **options)
    _place_camera(plotter, view, surface, low, high)
    image = np.asarray(plotter.screenshot(return_img=True, transparent_background=True))
    plotter.close()
    return image


def _place_camera(plotter: Any, view: View, surface: Surface, low: Array, high: Array) -> None:
    """Orthographic camera on the rectangle from `low` to `high`, and the light."""
    import pyvista

    frame = np.array([view.right, view.up, view.towards_eye])
    centre = 0.5 * (low + high)
    depth = float((surface.points @ view.towards_eye).mean())
    focus = np.array([*centre, depth]) @ frame
    camera = plotter.camera
    camera.enable_parallel_projection()
    camera.focal_point, camera.up = focus, view.up
    camera.position = focus + 200.0 * view.towards_eye
    camera.parallel_scale = 0.5 * (high - low)[1]
    camera.clipping_range = (50.0, 350.0)
    plotter.add_light(
        pyvista.Light(position=focus + 200.0 * (LIGHT @ frame), focal_point=focus, intensity=1.0)
    )


def _draw_painted(ax: Axes, surface: Surface, view: View, look: Look) -> None:
    """Painter's algorithm: faces turned to the eye, the farthest first."""
    corners = surface.points[surface.faces]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    depth = corners.mean(axis=1) @ view.towards_eye
    seen = np.flatnonzero(normal @ view.towards_eye > 0.0)
    seen = seen[np.argsort(depth[seen], kind="stable")]
    frame = np.array([view.right, view.up, view.towards_eye])
    ambient = AMBIENT if surface.values is None else VALUE_AMBIENT
    shade = ambient + (1.0 - ambient) * np.clip(normal[seen] @ (LIGHT @ frame), 0.0, 1.0)
    colours = np.clip(_face_colours(surface, look)[seen] * shade[:, None], 0.0, 1.0)
    edges: dict[str, Any] = {"edgecolors": "#303030", "linewidths": 0.15} if look.edges else {}
    faces = PolyCollection(
        list(view.project(corners.reshape(-1, 3)).reshape(*corners.shape[:2], 2)[seen]),
        facecolors=colours, rasterized=True, zorder=2,
        **(edges or {"edgecolors": colours, "linewidths": 0.35}),
    )  # fmt: skip
    ax.add_collection(faces, autolim=False)


def _face_colours(surface: Surface, look: Look) -> Array:
    """Unshaded colours (m, 3) of the faces."""
    if surface.values is None:
        return np.tile(to_rgb(look.colour), (len(surface.faces), 1))
    mean = surface.values[surface.faces].mean(axis=1)
    low, high = look.limits if look.limits else (float(mean.min()), float(mean.max()))
    return np.asarray(mpl.colormaps[STRAIN_MAP](Normalize(low, high, clip=True)(mean)))[:, :3]
