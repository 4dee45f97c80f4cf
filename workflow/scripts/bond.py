"""Force of a sample bonded by height, and by a simulated pre-load (rule `bond`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.constitutive.ogden import of_fit
from softsample.io import read_json, read_mesh_with_data, read_record, write_json
from softsample.response.bond import BondSettings, by_rule
from softsample.units import MM
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    loading = MeasuredCurve.of_record(read_record(files.records[0]), given.mode)
    report = by_rule(
        read_mesh_with_data(files.mesh),
        given.mode,
        of_fit(read_json(files.fit)),
        loading.travel,
        read_json(files.response)["loading_time_s"],
        given.preload_mm * MM,
        BondSettings(**given.bond),
        {name: given[name] for name in ("solver", "contact", "material", "ends")},
    )
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
