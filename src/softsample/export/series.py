"""The deformation of a test as a series that ParaView plays."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

from softsample.fem.fields import Snapshot, principal_hencky_strains
from softsample.io import PathLike, write_mesh, write_text
from softsample.meshing.mesh import HexMesh
from softsample.units import MM


def write_series(path: PathLike, mesh: HexMesh, snapshots: Sequence[Snapshot]) -> None:
    """Write a collection `{name}.pvd` and its meshes `{name}/000.vtu`, ..., each atomically.

    Time is the platen's travel in mm. Points hold `displacement_mm` and `held`, elements
    `max_principal_hencky_strain` and the three `principal_hencky_strains`, ascending. The
    collection is written last: it never names a mesh that is not there.

    Parameters
    ----------
    path
        Target, ending in `.pvd`.
    mesh : HexMesh
        Reference configuration [m]; *Warp By Vector* shows the deformed one.
    snapshots : sequence of Snapshot
        In the order of travel.
    """
    target = Path(path)
    root = ET.Element("VTKFile", type="Collection", version="1.0", byte_order="LittleEndian")
    collection = ET.SubElement(root, "Collection")
    for number, snapshot in enumerate(snapshots):
        file = f"{target.stem}/{number:03d}.vtu"
        strains = principal_hencky_strains(mesh, snapshot.displacement)
        write_mesh(
            target.parent / file,
            mesh,
            {"displacement_mm": snapshot.displacement / MM, "held": snapshot.held},
            {"max_principal_hencky_strain": strains[:, -1], "principal_hencky_strains": strains},
        )
        time = f"{snapshot.travel / MM:.10g}"
        ET.SubElement(collection, "DataSet", timestep=time, group="", part="0", file=file)
    ET.indent(root)
    write_text(target, '<?xml version="1.0"?>\n' + ET.tostring(root, "unicode") + "\n")
