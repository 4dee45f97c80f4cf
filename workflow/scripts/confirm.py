"""One test with the calibrated material: curve, deformed shape and strain (rule `confirm`)."""

from softsample import io
from softsample.constitutive.ogden import of_fit
from softsample.protocol import travel_sign
from softsample.records import reach
from softsample.response.curves import ResponseCurves
from softsample.response.optimum import optimum
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files, written = snakemake.params, snakemake.input, snakemake.output
    response, sample = io.read_json(files.response), io.read_mesh_with_data(files.mesh)
    shape = io.read_shape(files.cuboid)
    material = of_fit(io.read_json(files.fit))
    travel = response["reached"] * reach(map(io.read_record, files.records), given.mode)
    test = given.mode, given, given.ends
    found = optimum(sample, shape, test, material, travel, response, progress_bar())
    curves = ResponseCurves.of_table(io.read_table(files.curves), given.mode)
    compared = found.difference_percent(curves, material)
    own = {"travel_mm": 1e3 * travel, "against_calibrated_curve_percent": compared}
    for name, table in found.tables(travel_sign(given.mode)).items():
        io.write_table(written[name], table)
    io.write_mesh(written.fields, sample[0], *found.fields(*sample[:2]))
    io.write_json(written.report, {**own, **found.report, "provenance": provenance(snakemake)})
