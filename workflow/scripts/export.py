"""The calibrated test for other programs: input, material cards, mesh, curve (rule `export`)."""

import shutil

import numpy as np

from softsample.constitutive.ogden import of_fit
from softsample.errors import InputError
from softsample.export.abaqus import write_abaqus
from softsample.export.cards import write_card
from softsample.export.febio import write_febio
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.io import (
    read_json,
    read_mesh_with_data,
    read_record,
    read_table,
    write_table,
    written_aside,
)
from softsample.records import reach
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, written = snakemake.params, snakemake.output
    fit = read_json(snakemake.input.fit)
    mesh, point_data, cell_data = read_mesh_with_data(snakemake.input.mesh)
    if "region" in cell_data:
        raise InputError(
            f"{snakemake.input.mesh}: regions of different stiffness are not exported; "
            "leave the column labels of the table empty to export the sample without them"
        )
    travel = reach([read_record(path) for path in snakemake.input.records], given.mode)
    material = of_fit(fit)
    contact = ContactSettings(**given.contact)
    glued = np.flatnonzero(point_data["glued"])
    boundary = mode_boundary(mesh, given.mode, glued, contact, given.ends)
    test = (mesh, material, boundary, travel)
    write_abaqus(written.abaqus, *test)
    write_abaqus(written.calculix, *test, program="calculix")
    write_febio(written.febio, *test)
    origin = f"group {fit['group']}, {fit['geometry']} geometry, {fit['verdict']}"
    for program in ("abaqus", "calculix", "febio"):
        write_card(written[f"{program}_card"], material, program, origin)
    curve = read_table(snakemake.input.curve)
    own = curve["sample"] == snakemake.wildcards.sample
    write_table(written.curve, curve[own].drop(columns="sample"))
    for shape in ("mesh", "surface"):
        with written_aside(written[shape]) as aside:
            shutil.copyfile(snakemake.input[shape], aside)
