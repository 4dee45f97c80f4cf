"""Unit-modulus response of one piece and geometry (rule `simulate`)."""

from softsample.fem.setup import set_up
from softsample.io import read_json, read_mesh_with_data, read_record, write_json, write_table
from softsample.records import reach
from softsample.response.unit import (
    ResponseSettings,
    as_far_as_elements_stand,
    homogeneous_response,
    is_homogeneous,
    modulus_fractions,
    response_table,
    simulated_response,
)
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    travel = reach([read_record(path) for path in files.records], given.mode)
    fractions = modulus_fractions(ResponseSettings(**given.family))
    law = (fractions, given.material["alpha"], given.material["poisson_ratio"])
    if snakemake.wildcards.geometry == "ideal" and is_homogeneous(given.mode, given.ends):
        shape = IdealShape.of_report(read_json(files.cuboid))
        found = homogeneous_response(shape, given.mode, travel, *law, given.solver["curve_points"])
    else:
        sections = {name: given[name] for name in ("solver", "contact", "material", "ends")}
        model, preliminary = (
            set_up(*read_mesh_with_data(path), given.mode, **sections)
            for path in (files.mesh, files.preliminary)
        )
        found = as_far_as_elements_stand(
            lambda part: simulated_response(*model, part, *law, progress_bar(), preliminary), travel
        )
    curves, report = found
    write_table(snakemake.output.curves, response_table(curves, given.mode))
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
