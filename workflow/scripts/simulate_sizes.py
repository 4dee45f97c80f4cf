"""What effects of a verdict do to a sample's force, run at their sizes (rule `simulate_sizes`)."""

from functools import partial

from softsample.constitutive.ogden import of_fit
from softsample.io import read_distance, read_json, read_marks, read_record, read_shape, write_table
from softsample.loop.confirm import of_mode, sizes_to_confirm
from softsample.records import reach
from softsample.response.at_size import at_size, simulate_sizes
from softsample.response.changes import table_of_changes
from softsample.response.pieces import MechanicalTest, mesher
from softsample.workflow import logged_to

with logged_to(snakemake):
    files, given = snakemake.input, {**snakemake.params, "normal": False}
    shape = read_shape(files.cuboid)
    marks = partial(read_marks, files.bond_mask, files.labels, files.segmentation)
    grid = partial(read_distance, files.distance, files.segmentation)
    mesh_shifted = mesher(snakemake.wildcards.geometry, shape, lambda: (grid(), marks()), given)
    material = of_fit(read_json(files.fit))
    travel = reach([read_record(path) for path in files.records], given["mode"])
    test = MechanicalTest.of(material, travel, given)
    sizes = of_mode(sizes_to_confirm(read_json(files.verdict)), test.mode)
    displacement, changes = simulate_sizes(mesh_shifted, test, sizes)
    changes = {at_size(name): change for name, change in changes.items()}
    table = table_of_changes(test.mode, test.material.mu1_fraction, displacement, changes)
    write_table(snakemake.output.changes, table)
