"""Runs on the inner and the outer surface of the one-sigma band of a sample's boundary."""

from collections.abc import Callable, Mapping
from typing import Any

from softsample.constitutive.material import Material
from softsample.fem.boundary import Ends
from softsample.fem.explicit import Run
from softsample.fem.setup import Sample, set_up
from softsample.meshing.levelset import LevelSet
from softsample.meshing.mesh import HexMesh
from softsample.meshing.morph import shifted

STANDARD_DEVIATIONS = {"inner": -1.0, "real": 0.0, "outer": 1.0}
"""By which the surface is moved, by its name."""


def simulate_band(
    sample: Sample,
    surface: LevelSet,
    sigma: LevelSet,
    test: tuple[str, Mapping[str, Any], Ends],
    loaded: tuple[Material, float, float],
    progress: Callable[[str, float], None],
) -> dict[str, tuple[HexMesh, Run]]:
    """Mesh and run on each surface.

    Parameters
    ----------
    sample : tuple
        Mesh with its data.
    surface, sigma : LevelSet
        Signed distance of the surface, and standard deviation of its place [m].
    test : tuple
        Mode, sections of the config and ends, as of `softsample.fem.setup.set_up`.
    loaded : tuple
        Material, displacement of the platen [m] and loading time [s].
    progress : callable
        Told the surface and the finished part.
    """
    mesh, point_data, cell_data = sample
    material, travel, loading_time = loaded
    found = {}
    for done, (name, times) in enumerate(STANDARD_DEVIATIONS.items()):
        progress(name, done / len(STANDARD_DEVIATIONS))
        moved = shifted(mesh, surface, sigma, times) if times else mesh
        model, boundary = set_up((moved, point_data, cell_data), *test)
        found[name] = moved, model.run(material, boundary, travel, loading_time=loading_time)
    return found
