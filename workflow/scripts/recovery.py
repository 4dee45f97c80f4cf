"""Why moduli on the real geometry are off the sealed truth (rule `recovery`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings
from softsample.io import read_json, read_record, read_table, write_table
from softsample.response.curves import ResponseCurves
from softsample.scoring import (
    against_truth_mesh,
    contact_zero_error,
    contact_zero_part,
    noise_part,
    recovery_table,
)
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    families, measured, starts, meshes = {}, {}, {}, {}
    for at, (sample, mode) in enumerate(zip(given.samples, given.modes, strict=True)):
        families[sample] = ResponseCurves.of_table(read_table(files.curves[at]), mode)
        measured[sample] = MeasuredCurve.of_record(read_record(files.records[at]), mode)
        truth, cuboid = read_json(files.truth[at]), read_json(files.cuboids[at])
        meshes[sample] = against_truth_mesh(truth, cuboid)
        if mode == "compression":
            starts[sample] = contact_zero_error(truth, cuboid)
    parts = {
        group: contact_zero_part(
            {sample: families[sample] for sample in members},
            {sample: measured[sample] for sample in members},
            starts,
            read_json(fit)["mu_pa"],
            CalibrationSettings(**given.settings),
        )
        for (group, members), fit in zip(given.groups.items(), files.fits, strict=True)
    }
    table = recovery_table(
        read_table(files.score),
        parts,
        {sample: 1e3 * start for sample, start in starts.items()},
        {sample: noise_part(curve) for sample, curve in measured.items()},
        meshes,
        read_table(files.sensitivity),
        read_table(files.band),
    )
    write_table(snakemake.output.table, table)
