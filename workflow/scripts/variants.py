"""What each change of the model does to a sample's force (rule `variants`)."""

from softsample.calibration.curves import MeasuredCurve
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import SolverSettings
from softsample.io import read_distance, read_json, read_record, write_table
from softsample.loop.variants import Sample, VariantSettings, simulate_variants
from softsample.meshing.hexahedral import MeshSettings
from softsample.meshing.sample import SampleMesh, mesh_ideal, mesh_real
from softsample.protocol import travel_sign
from softsample.workflow import logged_to, progress_bar

MM = 1e-3


def meshed(shift: float) -> SampleMesh:
    """The sample on the loop's mesh, its surface moved out by `shift` [m]."""
    size = given.element_size_mm * MM
    if snakemake.wildcards.geometry == "ideal":
        cuboid = read_json(snakemake.input.cuboid)
        length, width, height = (cuboid[f"{name}_mm"] * MM for name in EDGES)
        return mesh_ideal(length + 2 * shift, width + 2 * shift, height + shift, size)
    keys = {
        k: v for k, v in given.mesh.items() if k not in ("element_size_mm", "boundary_shift_mm")
    }
    grid = read_distance(snakemake.input.distance, snakemake.input.segmentation)
    shift += given.mesh["boundary_shift_mm"] * MM
    return mesh_real(*grid, size, given.preload_mm * MM, MeshSettings(**keys), boundary_shift=shift)


EDGES = ("length", "width", "height")

with logged_to(snakemake.log[0]):
    given = snakemake.params
    settings = VariantSettings(**given.variants)
    plain, shifted = meshed(0.0), meshed(settings.shift_mm * MM)
    sample = Sample(
        plain.mesh,
        shifted.mesh,
        plain.point_data["glued"].nonzero()[0],
        shifted.point_data["glued"].nonzero()[0],
        given.mode,
    )
    displacement, changes = simulate_variants(
        sample,
        OgdenMaterial.of_fit(read_json(snakemake.input.fit)),
        MeasuredCurve.of_record(read_record(snakemake.input.record), given.mode).travel,
        ContactSettings(**given.contact),
        SolverSettings(**given.solver),
        settings,
        progress_bar(),
    )
    sign = travel_sign(given.mode)
    write_table(
        snakemake.output.changes,
        {
            "displacement_mm": sign * displacement / MM,
            **{f"{name}_mm2": sign * change / MM**2 for name, change in changes.items()},
        },
    )
