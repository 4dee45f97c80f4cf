"""Quick looks at intermediate results: an image, a mesh, a curve."""

from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from softsample.arrays import Array
from softsample.units import MM

LABELS = {
    "displacement_mm": "displacement [mm]",
    "force_N": "force [N]",
    "measured_N": "measured",
    "model_N": "model",
    "force_per_mu_mm2": "force / shear modulus [mm²]",
}


def slices(data: NDArray[Any], affine: Array, title: str) -> Figure:
    """Three orthogonal slices through the middle of a volume.

    Parameters
    ----------
    data : (nx, ny, nz)
        Intensities, or distances.
    affine : (4, 4) float64
        From voxel index to world [mm]; its column lengths are the voxel sizes.
    title
        Written above.
    """
    voxel = np.linalg.norm(affine[:3, :3], axis=0)
    figure = Figure(figsize=(10, 3.6), layout="constrained")
    low, high = np.percentile(data, [0.5, 99.5])
    for axis, ax in enumerate(figure.subplots(1, 3)):
        across, up = (i for i in range(3) if i != axis)
        middle = data.shape[axis] // 2
        extent = (0.0, voxel[across] * data.shape[across], 0.0, voxel[up] * data.shape[up])
        picture = ax.imshow(
            np.take(data, middle, axis).T,
            origin="lower",
            extent=extent,
            vmin=low,
            vmax=high,
            cmap="gray",
        )
        ax.set(xlabel=f"{'ijk'[across]} [mm]", ylabel=f"{'ijk'[up]} [mm]")
        ax.set_title(f"{'ijk'[axis]} = {middle}", fontsize=9)
    figure.colorbar(picture, ax=figure.axes, shrink=0.8)
    figure.suptitle(title)
    return figure


def faces(
    corners: Array, title: str, name: str | None = None, values: NDArray[Any] | None = None
) -> Figure:
    """Faces of a surface, coloured if they have values (matplotlib).

    Parameters
    ----------
    corners : (n, 3, 3) or (n, 4, 3) float64
        Corners of the triangles or quads [m].
    title
        Written above.
    name, values : (n,)
        What to colour the faces by, if anything.
    """
    figure = Figure(figsize=(8, 6), layout="constrained")
    ax = figure.add_subplot(projection="3d")
    corners = corners / MM
    drawn = Poly3DCollection(corners, linewidths=0.1, edgecolors="0.2")
    if name is None or values is None:
        drawn.set_facecolor("0.8")
    else:
        scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(values.min(), values.max()), "viridis")
        drawn.set_facecolor(scale.to_rgba(values))
        figure.colorbar(scale, ax=ax, label=name.replace("_", " "), shrink=0.6)
    ax.add_collection3d(drawn)
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(high - low)
    ax.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]", title=title)
    return figure


def render(path: str, cell_name: str | None) -> NDArray[np.uint8]:
    """(height, width, 3) picture of a VTU or STL file by VTK; ask `rendering_works` before."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=(1200, 900))
    plotter.add_mesh(
        pyvista.read(path),
        scalars=cell_name,
        show_edges=True,
        cmap="viridis",
        color="lightgray",
        scalar_bar_args={
            "title": (cell_name or "").replace("_", " "),
            "width": 0.5,
            "position_x": 0.25,
            "position_y": 0.02,
        },
    )
    plotter.show_grid(xtitle="x [mm]", ytitle="y [mm]", ztitle="z [mm]")
    plotter.camera_position = [(1.0, -1.6, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    plotter.reset_camera()
    plotter.camera.zoom(0.85)
    return np.asarray(plotter.screenshot(return_img=True))


def curves(table: pd.DataFrame, title: str) -> Figure:
    """Forces of a table against displacement, one line for each sample or mixture in it.

    Parameters
    ----------
    table
        Column `displacement_mm`, forces in the columns of `LABELS`, and perhaps a column
        `sample` or `mu1_fraction` that names the curve.
    title
        Written above.
    """
    figure = Figure(figsize=(7, 5), layout="constrained")
    ax = figure.add_subplot()
    forces = [name for name in LABELS if name in table and name != "displacement_mm"]
    key = next((name for name in ("sample", "mu1_fraction") if name in table), None)
    groups = table.groupby(key) if key else [("", table)]
    for label, part in groups:
        for name in forces:
            shown = " ".join(filter(None, [str(label), LABELS[name] if len(forces) > 1 else ""]))
            style = "." if name == "measured_N" else "-"
            ax.plot(part["displacement_mm"], part[name], style, ms=2, label=shown or None)
    ax.set(xlabel=LABELS["displacement_mm"], title=title)
    ax.set_ylabel(LABELS[forces[0]] if len(forces) == 1 else "force [N]")
    if key or len(forces) > 1:
        ax.legend(title={"mu1_fraction": "mu1 / mu"}.get(str(key)), fontsize=8)
    return figure
