"""Every law of the dictionary on the tests of a group (rule `laws_of_group`)."""

from softsample import io
from softsample.laws.group import LawSettings, group_report
from softsample.laws.setup import SamplesOfGroup, SimulatedPiece
from softsample.response.floor import FloorSettings
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files, settings = snakemake.params, snakemake.input, LawSettings(**snakemake.params.laws)
    records = [*map(io.read_record, files.records)]
    shapes = [*map(io.read_shape, files.cuboids)]
    samples = SamplesOfGroup(given.rows, given.pieces, records, shapes, given)
    meshes, reports = map(io.read_mesh_with_data, files.meshes), map(io.read_json, files.reports)
    fractions = [io.read_json(path)["mu1_fraction"] for path in files.fits]
    pieces = map(SimulatedPiece, given.simulated, given.ends, meshes, reports)
    levels = zip(pieces, map(io.read_table, files.curves), fractions, strict=True)
    simulated = {level[0].name: samples.anchored(*level) for level in levels}
    qualities = zip(given.simulated, map(io.read_json, files.qualities), strict=True)
    sizes = {name: quality["element_size_mm"] for name, quality in qualities}
    errors = FloorSettings(**given.floor), given.contact_zero_mm
    tests = samples.tests(simulated, sizes, *errors, given.hold_out)
    laws = settings.laws(given.material["alpha"]), given.folds, settings.tolerance, given.confidence
    found, curves = group_report(tests, *laws, progress_bar())
    io.write_table(snakemake.output.curves, curves)
    own = {"group": snakemake.wildcards.group, "modes": [row["mode"] for row in given.rows]}
    io.write_json(snakemake.output.report, {**own, **found, "provenance": provenance(snakemake)})
