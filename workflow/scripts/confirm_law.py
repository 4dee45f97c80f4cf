"""The chosen law on the study's mesh beside what the fit took for it (rule `confirm_law`)."""

import pandas as pd

from softsample.fem.setup import set_up
from softsample.io import read_json, read_mesh_with_data, read_record, read_table, write_table
from softsample.laws.group import LawSettings
from softsample.laws.response import HomogeneousResponse
from softsample.laws.setup import confirmed
from softsample.laws.simulate import SimulatedResponse
from softsample.records import reach
from softsample.shapes import IdealShape
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    name = read_json(files.choice)["groups"][snakemake.wildcards.group]["best"][0]
    laws = LawSettings(**given.laws).laws(given.material["alpha"])
    candidate = next(law for law in laws if law.name == name)
    fitted = read_json(files.report)["laws"][name]
    table = read_table(files.laws)
    records = dict(zip(given.samples, map(read_record, files.records), strict=True))
    piece_of = dict(zip(given.samples, given.pieces, strict=True))
    sections = {name: given[name] for name in ("solver", "contact", "material")}
    rows = []
    for piece, mode, ends, cuboid, mesh, report in zip(
        given.simulated, given.modes, given.ends, files.cuboids, files.meshes, files.reports,
        strict=True,
    ):  # fmt: skip
        own = [name for name in given.samples if piece_of[name] == piece]
        shape, known = IdealShape.of_report(read_json(cuboid)), read_json(report)
        response = SimulatedResponse(
            *set_up(*read_mesh_with_data(mesh), mode, **sections, ends=ends),
            known["reached"] * reach([records[name] for name in own], mode),
            known["loading_time_s"],
            HomogeneousResponse(shape, mode, given.material["poisson_ratio"]),
        )
        rows += confirmed(response, candidate, fitted, table[table["sample"].isin(own)])
    write_table(snakemake.output.table, pd.DataFrame(rows))
