"""What changes of the model do to the response of a piece (rule `perturbations`)."""

from functools import partial

from softsample.constitutive.ogden import of_fit
from softsample.io import read_distance, read_json, read_marks, read_record, read_shape, write_table
from softsample.records import reach
from softsample.response.perturbations import perturbations_of
from softsample.response.pieces import MechanicalTest, mesher
from softsample.workflow import logged_to, progress_bar

with logged_to(snakemake):
    files, given = snakemake.input, dict(snakemake.params.items())
    records = [read_record(path) for path in files.records]
    given["normal"] = any(record.force_normal is not None for record in records)
    shape = read_shape(files.cuboid)
    geometry = snakemake.wildcards.geometry
    marks = partial(read_marks, files.bond_mask, files.labels, files.segmentation)
    grid = partial(read_distance, files.distance, files.segmentation)
    mesh_shifted = mesher(geometry, shape, lambda: (grid(), marks()), given)
    material = of_fit(read_json(files.fit))
    test = MechanicalTest.of(material, reach(records, given["mode"]), given)
    changes = perturbations_of(geometry, shape, mesh_shifted, test, progress_bar())
    write_table(snakemake.output.changes, changes)
