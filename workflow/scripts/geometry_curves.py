"""Curves of a sample and its cuboid with features of the shape changed (rule `geometry_curves`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.geometry_effects.shapes import Shape
from softsample.geometry_effects.variants import EffectSettings, simulate, variants
from softsample.io import read_distance, read_json, read_record, write_table
from softsample.meshing.sample import mesh_ideal, mesh_real
from softsample.protocol import PRESSED_MODES
from softsample.response.bond import CONTACT, touched_nodes
from softsample.response.unit import ResponseSettings, modulus_fractions
from softsample.shapes import IdealShape, element_size
from softsample.workflow import logged_to, progress_bar

MM = 1e-3

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    mesh, effects = given.mesh, dict(given.effects)
    ideal = IdealShape.of_report(read_json(files.cuboid))
    coarser = effects.pop("element_size_mm") / mesh["element_size_mm"]
    size = coarser * element_size(ideal, mesh["element_size_mm"] * MM, mesh["elements_across"])
    preload = given.preload_mm * MM
    real = mesh_real(
        *read_distance(files.distance, files.segmentation),
        size,
        preload,
        boundary_shift=mesh["boundary_shift_mm"] * MM,
    )
    contact, solver = ContactSettings(**given.contact), SolverSettings(**given.solver)
    law = given.material["alpha"], given.material["poisson_ratio"]
    pressed, by_contact = given.mode in PRESSED_MODES, given.bond["rule"] == CONTACT
    touched = (
        None
        if pressed
        else touched_nodes(
            ExplicitModel(real.mesh, solver), preload, given.bond["fill_mm"] * MM, *law, contact
        )
    )
    shape = Shape(real.mesh, mesh_ideal(ideal, size).mesh, ideal, given.top_normal_deg)
    table = simulate(
        variants(shape, given.mode, preload, EffectSettings(**effects), touched, by_contact),
        given.mode,
        MeasuredCurve.of_record(read_record(files.record), given.mode).travel,
        [*modulus_fractions(ResponseSettings(**given.family))],
        *law,
        contact,
        solver,
        read_json(files.family)["loading_time_s"],
        progress_bar(),
    )
    write_table(snakemake.output.curves, table)
