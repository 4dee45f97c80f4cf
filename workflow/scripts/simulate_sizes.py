"""What effects of a verdict do to a sample's force, run at their sizes (rule `simulate_sizes`)."""

from softsample.io import read_distance, read_json, read_marks, read_record, write_table
from softsample.loop.confirm import at_size, simulate_sizes, sizes_to_confirm
from softsample.response.changes import table_of_changes
from softsample.response.pieces import MechanicalTest, mesher
from softsample.workflow import logged_to

with logged_to(snakemake):
    files, given = snakemake.input, dict(snakemake.params.items())
    mesh_shifted = mesher(
        snakemake.wildcards.geometry,
        read_distance(files.distance, files.segmentation),
        read_json(files.cuboid),
        read_marks(files.bond_mask, files.labels, files.segmentation),
        given,
    )
    test = MechanicalTest.of(read_json(files.fit), read_record(files.record), given)
    sizes = sizes_to_confirm(read_json(files.verdict))
    displacement, changes = simulate_sizes(mesh_shifted, test, sizes)
    changes = {at_size(name): change for name, change in changes.items()}
    write_table(snakemake.output.changes, table_of_changes(test.mode, displacement, changes))
