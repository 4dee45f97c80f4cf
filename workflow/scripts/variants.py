"""What changes of the model do to a sample's force (rule `variants`)."""

from softsample.io import read_distance, read_json, read_marks, read_record, write_table
from softsample.loop.changes import table_of_changes
from softsample.loop.inputs import MechanicalTest, mesher
from softsample.loop.variants import simulate_variants
from softsample.workflow import logged_to, progress_bar

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
    found = simulate_variants(mesh_shifted, test, progress_bar(), turn=test.travel)
    write_table(snakemake.output.changes, table_of_changes(test.mode, *found))
