"""Why moduli on the real geometry are off the sealed truth (rule `recovery`)."""

from softsample import io
from softsample.calibration.slsqp import CalibrationSettings
from softsample.scoring import CohortSample, recovery
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    samples = map(
        CohortSample.of,
        given.samples,
        given.modes,
        map(io.read_json, files.truth),
        map(io.read_json, files.cuboids),
        map(io.read_table, files.curves),
        map(io.read_record, files.records),
    )
    moduli = [io.read_json(path)["mu_pa"] for path in files.fits]
    table = recovery(
        [*samples],
        given.groups,
        dict(zip(given.groups, moduli, strict=True)),
        CalibrationSettings(**given.settings),
        *(io.read_table(files[name]) for name in ("score", "sensitivity", "band")),
    )
    io.write_table(snakemake.output.table, table)
