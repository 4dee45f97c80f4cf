"""Unit-modulus response of one piece and geometry (rule `simulate`)."""

from softsample.fem.setup import set_up
from softsample.io import read_mesh_with_data, read_record, read_shape, write_json, write_table
from softsample.protocol import is_homogeneous
from softsample.records import reach
from softsample.response import unit
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    travel = reach(map(read_record, files.records), given.mode)
    law = given.material["alpha"], given.material["poisson_ratio"]
    points, bar = given.solver["curve_points"], progress_bar()
    if snakemake.wildcards.geometry == "ideal" and is_homogeneous(given.mode, given.ends):
        shape = read_shape(files.cuboid)
        found = unit.homogeneous_response(shape, given.mode, travel, unit.EXACT, *law, points)
    else:
        law = unit.modulus_fractions(unit.ResponseSettings(**given.family)), *law
        model, preliminary = (
            set_up(read_mesh_with_data(path), given.mode, given, given.ends)
            for path in (files.mesh, files.preliminary)
        )
        found = unit.as_far_as_elements_stand(
            lambda part: unit.simulated_response(*model, part, *law, bar, preliminary), travel
        )
    curves, report = found
    write_table(snakemake.output.curves, unit.response_table(curves, given.mode))
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
