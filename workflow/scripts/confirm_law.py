"""A law on the study's mesh beside what the fit took for it (rules `confirm_law` and others)."""

import pandas as pd

from softsample import io
from softsample.laws.group import LawSettings
from softsample.laws.setup import SamplesOfGroup, SimulatedPiece
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    name = given.law or io.read_json(files.choice)["groups"][snakemake.wildcards.group]["best"][0]
    laws = LawSettings(**given.laws).laws(given.material["alpha"])
    chosen = next(law for law in laws if law.name == name)
    fits = io.read_json(files.report), io.read_table(files.laws)
    records = [*map(io.read_record, files.records)]
    shapes = [*map(io.read_shape, files.cuboids)]
    samples = SamplesOfGroup(given.rows, given.pieces, records, shapes, given)
    meshes, reports = map(io.read_mesh_with_data, files.meshes), map(io.read_json, files.reports)
    pieces = map(SimulatedPiece, given.simulated, given.ends, meshes, reports)
    tables = [samples.confirmed(piece, chosen, *fits) for piece in pieces]
    io.write_table(snakemake.output.table, pd.concat(tables))
