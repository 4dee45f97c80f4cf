"""Our one-point elements against three-field ones on the same meshes (rule `element_type`)."""

from functools import partial

import numpy as np
import pandas as pd

from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings, glued_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.io import write_table
from softsample.meshing.mesh import HexMesh
from softsample.response.unit import find_pace
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files, rows = snakemake.params, snakemake.input, []
    reference = ContactSettings(release=False, side_walls=False, base_platen=False)
    for mode, mesh_path, curve_path in zip(given.modes, files.meshes, files.curves, strict=True):
        data = np.load(mesh_path)
        mesh = HexMesh(1e-3 * data["nodes_mm"], data["hex8"].astype(np.int64))
        curve = np.genfromtxt(curve_path, delimiter=",", names=True)
        axis, sign = ("x", 1.0) if mode == "shear" else ("z", -1.0)
        travel = sign * 1e-3 * curve[f"u{axis}_mm"][-1]
        force = sign * curve[f"F{axis}_N"][-1]
        if mode == "shear":
            boundary = glued_boundary(mesh, mode, data["top"].astype(np.int64))
        else:
            boundary = platen_boundary(mesh, reference)
        settings, material = SolverSettings(**given.solver), OgdenMaterial(**given.material)
        loaded = partial(ExplicitModel(mesh, settings).run, material, boundary, travel)
        pace = find_pace(
            lambda time, run=loaded: run(loading_time=time),
            settings.loading_time_s,
            settings.curve_error_percent,
        )
        own = pace.run.force[-1]
        rows.append(
            {
                "mode": mode,
                "edge_mm": 1e3 * mesh.edge_length,
                "elements": len(mesh.hexes),
                "one_point_N": own,
                "three_field_N": force,
                "three_field_over_one_point_percent": 100.0 * (force / own - 1.0),
            }
        )
    write_table(snakemake.output.table, pd.DataFrame(rows))
