"""A calibrated test as input of every program."""

from collections.abc import Mapping

import numpy as np

from softsample.constitutive.material import Material
from softsample.errors import InputError
from softsample.export.abaqus import write_abaqus
from softsample.export.cards import CONVENTIONS, write_card
from softsample.export.febio import write_febio
from softsample.fem.boundary import ContactSettings, Ends, mode_boundary
from softsample.fem.setup import Sample


def export_test(
    paths: Mapping[str, str],
    source: str,
    sample: Sample,
    material: Material,
    test: tuple[str, Ends, ContactSettings],
    travel: float,
    origin: str,
) -> None:
    """Write input and material card of Abaqus, CalculiX and FEBio.

    Parameters
    ----------
    paths : mapping
        Targets: `abaqus`, `calculix`, `febio`, and `{program}_card`.
    source : str
        File of the mesh, for messages.
    sample : tuple
        Mesh with its data.
    material : Material
        With the calibrated parameters.
    test : tuple
        Mode, ends and settings of contact, as of `softsample.fem.boundary.mode_boundary`.
    travel : float
        Displacement of the platen [m].
    origin : str
        One line that says where the moduli are from.

    Raises
    ------
    InputError
        If the sample has regions of different stiffness, or a program lacks what the test needs.
    """
    mesh, point_data, cell_data = sample
    if "region" in cell_data:
        raise InputError(
            f"{source}: regions of different stiffness are not exported; leave the column labels "
            "of the table empty to export the sample without them"
        )
    mode, ends, contact = test
    boundary = mode_boundary(mesh, mode, np.flatnonzero(point_data["glued"]), contact, ends)
    static = (mesh, material, boundary, travel)
    write_abaqus(paths["abaqus"], *static)
    write_abaqus(paths["calculix"], *static, program="calculix")
    write_febio(paths["febio"], *static)
    for program in CONVENTIONS:
        write_card(paths[f"{program}_card"], material, program, origin)
