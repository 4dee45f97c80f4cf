"""Our one-point elements against three-field ones on the same meshes (rule `element_type`)."""

import numpy as np
import pandas as pd

from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.explicit import SolverSettings
from softsample.io import read_table, write_table
from softsample.response.element_type import against_one_point
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    settings, material = SolverSettings(**given.solver), OgdenMaterial(**given.material)
    meshes, curves = map(np.load, files.meshes), map(read_table, files.curves)
    others = zip(given.modes, meshes, curves, strict=True)
    rows = [against_one_point(*other, settings, material) for other in others]
    write_table(snakemake.output.table, pd.DataFrame(rows))
