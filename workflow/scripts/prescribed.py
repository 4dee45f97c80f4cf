"""Compression by contact and by moving the top's nodes (rule `prescribed`)."""

from softsample.constitutive.ogden import of_fit
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.geometry_effects.prescribed import simulate_both
from softsample.io import read_json, read_mesh, write_table
from softsample.workflow import logged_to, progress_bar

with logged_to(snakemake):
    given, bar = snakemake.params, progress_bar()
    height = 1e-3 * read_json(snakemake.input.cuboid)["height_mm"]
    table = simulate_both(
        ExplicitModel(read_mesh(snakemake.input.mesh), SolverSettings(**given.solver)),
        of_fit(read_json(snakemake.input.fit)),
        given.strain * height,
        ContactSettings(**given.contact),
        given.top_normal_deg,
        read_json(snakemake.input.family)["loading_time_s"],
        lambda fraction: bar("compression by contact, then prescribed", fraction),
    )
    curves = {
        "strain": table["displacement"] / height,
        "displacement_mm": 1e3 * table["displacement"],
        "contact_N": table["contact"],
        "prescribed_N": table["prescribed"],
    }
    write_table(snakemake.output.curves, curves)
