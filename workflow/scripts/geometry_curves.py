"""Curves of a sample and its cuboid with features of the shape changed (rule `geometry_curves`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import SolverSettings
from softsample.geometry_effects.shapes import Shape
from softsample.geometry_effects.variants import EffectSettings, simulate, variants
from softsample.io import read_distance, read_json, read_record, write_table
from softsample.meshing.hexahedral import MeshSettings
from softsample.meshing.sample import mesh_ideal, mesh_real
from softsample.response.unit import FamilySettings, family_fractions
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, progress_bar

MM = 1e-3

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    keys, effects = dict(given.mesh), dict(given.effects)
    size = effects.pop("element_size_mm") * MM
    del keys["element_size_mm"]
    shift, preload = keys.pop("boundary_shift_mm") * MM, given.preload_mm * MM
    ideal = IdealShape.of_report(read_json(files.cuboid))
    edges = (ideal.length, ideal.width, ideal.height)
    grid = read_distance(files.distance, files.segmentation)
    real = mesh_real(*grid, size, preload, MeshSettings(**keys), boundary_shift=shift)
    shape = Shape(real.mesh, mesh_ideal(ideal, size).mesh, edges, given.top_normal_deg)
    one_term = [1.0] if given.mode == "compression" else []
    table = simulate(
        variants(shape, given.mode, preload, EffectSettings(**effects)),
        given.mode,
        MeasuredCurve.of_record(read_record(files.record), given.mode).travel,
        [*family_fractions(FamilySettings(**given.family)), *one_term],
        given.material["alpha"],
        given.material["poisson_ratio"],
        ContactSettings(**given.contact),
        SolverSettings(**given.solver),
        read_json(files.family)["loading_time_s"],
        progress_bar(),
    )
    write_table(snakemake.output.curves, table)
