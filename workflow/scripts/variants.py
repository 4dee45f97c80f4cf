"""What changes of the model do to a sample's force (rules `variants`, `simulate_sizes`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import SolverSettings
from softsample.io import read_distance, read_json, read_record, write_table
from softsample.loop.confirm import at_size, simulate_sizes, sizes_to_confirm
from softsample.loop.variants import VariantSettings, coarse_sample, simulate_variants
from softsample.meshing.hexahedral import MeshSettings
from softsample.meshing.sample import mesh_ideal, mesh_real
from softsample.protocol import travel_sign
from softsample.workflow import logged_to, progress_bar

MM = 1e-3

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    keys, size = dict(given.mesh), given.element_size_mm * MM
    keys.pop("element_size_mm")
    segmented = keys.pop("boundary_shift_mm") * MM
    cuboid = read_json(files.cuboid)
    edges = [cuboid[f"{name}_mm"] * MM for name in ("length", "width", "height")]
    grid = read_distance(files.distance, files.segmentation)
    settings = VariantSettings(**given.variants)
    meshers = {
        "real": lambda shift: mesh_real(
            *grid,
            size,
            given.preload_mm * MM,
            MeshSettings(**keys),
            boundary_shift=segmented + shift,
        ),
        "ideal": lambda shift: mesh_ideal(
            edges[0] + 2.0 * shift, edges[1] + 2.0 * shift, edges[2] + shift, size
        ),
    }
    mesh_shifted, mode = meshers[snakemake.wildcards.geometry], given.mode
    travel = MeasuredCurve.of_record(read_record(files.record), mode).travel
    test = (
        OgdenMaterial.of_fit(read_json(files.fit)),
        travel,
        ContactSettings(**given.contact),
        SolverSettings(**given.solver),
        settings,
    )
    if files.get("verdict"):
        sizes = sizes_to_confirm(read_json(files.verdict))
        displacement, changes = simulate_sizes(mesh_shifted, mode, *test, sizes)
        changes = {at_size(name): change for name, change in changes.items()}
    else:
        sample = coarse_sample(mesh_shifted, mode, settings)
        displacement, changes = simulate_variants(sample, *test, progress_bar(), turn=travel)
    sign = travel_sign(mode)
    write_table(
        snakemake.output.changes,
        {
            "displacement_mm": sign * displacement / MM,
            **{f"{name}_mm2": sign * change / MM**2 for name, change in changes.items()},
        },
    )
