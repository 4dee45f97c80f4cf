"""One test with the calibrated material: curve, deformed shape and strain (rule `confirm`)."""

from softsample.constitutive.ogden import of_fit
from softsample.fem.fields import max_principal_hencky_strain
from softsample.fem.setup import set_up
from softsample.io import (
    read_json,
    read_mesh_with_data,
    read_record,
    read_table,
    write_json,
    write_mesh,
    write_table,
)
from softsample.protocol import travel_sign
from softsample.records import reach
from softsample.response.curves import ResponseCurves
from softsample.response.optimum import loading_time, sheared_optimum, simulated_optimum
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files, written = snakemake.params, snakemake.input, snakemake.output
    material, response = of_fit(read_json(files.fit)), read_json(files.response)
    data = read_mesh_with_data(files.mesh)
    mesh, point_data, _ = data
    travel = response["reached"] * reach([read_record(path) for path in files.records], given.mode)
    if given.mode == "shear" and given.ends == "sliding":
        shape = IdealShape.of_report(read_json(files.cuboid))
        found = sheared_optimum(mesh, shape, material, travel, given.solver["curve_points"])
    else:
        sections = {name: given[name] for name in ("solver", "contact", "material", "ends")}
        model, boundary = set_up(*data, given.mode, **sections)
        bar = progress_bar()
        found = simulated_optimum(
            model,
            boundary,
            material,
            travel,
            loading_time(response, model),
            lambda done: bar("run at the optimum", done),
        )
    modelled = ResponseCurves.of_table(read_table(files.curves), given.mode).force(
        found.displacement, material.shear_modulus, material.mu1_fraction
    )
    for name, table in found.tables(travel_sign(given.mode)).items():
        write_table(written[name], table)
    write_mesh(
        written.fields,
        mesh,
        {"displacement_mm": 1e3 * found.field, "held": found.held, **point_data},
        {"max_principal_hencky_strain": max_principal_hencky_strain(mesh, found.field)},
    )
    report = {
        "travel_mm": 1e3 * travel,
        "against_calibrated_curve_percent": found.difference_percent(modelled),
        **found.report,
        "provenance": provenance(snakemake),
    }
    write_json(written.report, report)
