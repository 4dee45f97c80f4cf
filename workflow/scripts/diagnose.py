"""Trace what the calibrated model leaves over to the effect that it lacks (rule `diagnose`)."""

import numpy as np

from softsample.calibration.curves import CurveFamily
from softsample.figures.loop import loop_figure
from softsample.figures.style import save
from softsample.io import read_json, read_record, read_table, write_json, write_text
from softsample.loop.diagnose import LoopSettings, diagnose, report
from softsample.loop.noise import NoiseSettings
from softsample.loop.page import page
from softsample.loop.select import SelectionSettings
from softsample.loop.specimen import Elastic, Specimen
from softsample.protocol import travel_sign
from softsample.workflow import logged_to, provenance

MM = 1e-3


def changes(path: str, family: CurveFamily, sign: float) -> dict[str, np.ndarray]:
    """Changes of the force per modulus [m2] on the displacements of the family."""
    table = read_table(path)
    travel = sign * MM * table.pop("displacement_mm").to_numpy()
    return {
        name.removesuffix("_mm2"): np.interp(
            family.displacement, travel, sign * MM**2 * table[name].to_numpy()
        )
        for name in table
    }


with logged_to(snakemake.log[0]):
    given, files = snakemake.params, snakemake.input
    keys = dict(given.loop)
    settings = LoopSettings(NoiseSettings(**keys["noise"]), SelectionSettings(**keys["selection"]))
    specimens = []
    for k, (name, mode) in enumerate(zip(given.samples, given.modes, strict=True)):
        sign = travel_sign(mode)
        family = CurveFamily.of_table(read_table(files.curves[k]), mode)
        variants = changes(files.variants[k], family, sign)
        if files.get("real"):
            real = CurveFamily.of_table(read_table(files.real[k]), mode)
            grid, mixture = family.displacement, read_json(files.fit)["mu1_fraction"]
            variants["real_geometry"] = real.force_per_mu(mixture, grid)
            variants["real_geometry"] -= family.force_per_mu(mixture, grid)
        elastic = Elastic(family, variants, contact=mode == "compression")
        specimens.append(Specimen.of_record(name, mode, read_record(files.records[k]), elastic))
    found = diagnose(specimens, settings)
    verdict = report(found, settings)
    write_json(snakemake.output.verdict, {**verdict, "provenance": provenance(snakemake)})
    write_text(snakemake.output.page, page(snakemake.wildcards.group, verdict))
    save(loop_figure(found), snakemake.output.figure)
