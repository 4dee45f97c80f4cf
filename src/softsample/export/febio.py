"""Input of FEBio 4 for a test."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Array
from softsample.constitutive.material import Material, Term
from softsample.export.laws import family, polynomial, powers, refuse
from softsample.export.model import MPA, StaticTest
from softsample.fem.boundary import Boundary
from softsample.io import PathLike, write_text
from softsample.meshing.mesh import HexMesh
from softsample.units import MM

Law = tuple[str, dict[str, float], tuple[float, float, float] | None]
"""Type of a material in FEBio, its constants [MPa], and the direction of its fibres."""

QUADRATIC = 2
"""FEBio's `pressure_model` for K/2 (J - 1)^2 ("Abaqus"); its default is K/2 (ln J)^2."""

UNCONSTRAINED = "Ogden unconstrained"
"""FEBio's type of a foam whose Poisson's ratio is 0."""

MOST_TERMS = 6
"""Largest number of terms with exponents."""

PULL = 1e-3
"""Traction at which a platen releases, over the shear modulus; FEBio takes 0 for 'never'."""

STEPS = 20
"""Number of time steps."""

TISSUE = 1
"""Material number of the sample; rigid bodies follow."""

TURNED = "TURNED"
"""Rigid body of what is glued in torsion."""


def write_febio(
    path: PathLike, mesh: HexMesh, material: Material, boundary: Boundary, travel: float
) -> None:
    """Write a static test as input of FEBio 4 (febio_spec 4.0), atomically.

    Parameters
    ----------
    path
        Target, ending in `.feb`.
    mesh : HexMesh
        Reference configuration [m].
    material : Material
        Moduli [Pa]; of Ogden solids FEBio's coefficients are ``c_i = 2 mu_i``, ``m_i = alpha_i``.
    boundary : Boundary
        Fixed base; nodes glued to the moving platen, or a platen or ball that free nodes can
        touch: rigid bodies with sticky or sliding contact.
    travel : float
        Travel of the moving platen [m], > 0, in proportion to time from 0 to 1.

    Raises
    ------
    InputError
        On a law that FEBio does not have, a travel that is not positive, or if nothing moves.

    Notes
    -----
    The force goes to `{name}_force.csv`: of the moving body (in torsion torque [N mm], then
    force), or of each glued node (their sum is the force). The file was checked against FEBio's
    documentation and sources, not run.

    References
    ----------
    S. A. Maas et al., J. Biomech. Eng. 134 (2012) 011005, doi:10.1115/1.4005694.
    """
    test = StaticTest(mesh, material, boundary, travel)
    root = ET.Element("febio_spec", version="4.0")
    root.extend(ET.Comment(f" {line} ") for line in test.header)
    ET.SubElement(root, "Module", type="solid")
    _control(ET.SubElement(root, "Control"))
    _materials(ET.SubElement(root, "Material"), test)
    _mesh(ET.SubElement(root, "Mesh"), test)
    _domains(ET.SubElement(root, "MeshDomains"), test)
    _boundary(ET.SubElement(root, "Boundary"), test)
    if _bodies(test):
        _rigid(ET.SubElement(root, "Rigid"), test)
    if test.plates:
        _contact(ET.SubElement(root, "Contact"), test)
    _ramp(ET.SubElement(root, "LoadData"))
    _output(ET.SubElement(root, "Output"), test, Path(path).stem)
    ET.indent(root)
    write_text(path, '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, "unicode"))


def _control(control: ET.Element) -> None:
    """Static analysis with full Newton iterations and steps that can be cut back."""
    _fill(control, analysis="STATIC", time_steps=STEPS, step_size=1.0 / STEPS)
    solver = ET.SubElement(control, "solver", type="solid")
    _fill(solver, symmetric_stiffness="symmetric", max_refs=25, dtol=1e-3, etol=1e-3, rtol=0)
    _fill(ET.SubElement(solver, "qn_method", type="BFGS"), max_ups=0)
    stepper = ET.SubElement(control, "time_stepper", type="default")
    _fill(stepper, max_retries=10, opt_iter=15, dtmin=1e-3 / STEPS, dtmax=1.0 / STEPS)


def _bodies(test: StaticTest) -> dict[str, tuple[Array, bool]]:
    """Rigid bodies: centre [mm], about which they turn, and whether they move."""
    bodies = {plate.name: (plate.body.points.mean(axis=0), plate.moves) for plate in test.plates}
    if test.angle:
        bodies[TURNED] = (np.array([0.0, 0.0, test.mesh.highest / MM]), True)
    return bodies


def _materials(materials: ET.Element, test: StaticTest) -> None:
    """The tissue, and the rigid bodies."""
    tissue = ET.SubElement(materials, "material", id=str(TISSUE), name="tissue")
    fill_tissue(tissue, test.material)
    for number, (name, (centre, _)) in enumerate(_bodies(test).items(), start=TISSUE + 1):
        body = ET.SubElement(materials, "material", id=str(number), name=name, type="rigid body")
        _fill(body, density=1.0, center_of_mass=_row(centre))


def fill_tissue(tissue: ET.Element, material: Material) -> None:
    """Give an element `material` its type and the constants [MPa] of the law.

    Raises
    ------
    InputError
        If FEBio has no such law.
    """
    kind, constants, axis = _law(material)
    tissue.set("type", kind)
    _fill(tissue, density=1.0)
    if kind != UNCONSTRAINED:
        _fill(tissue, k=material.volumetric_modulus / MPA, pressure_model=QUADRATIC)
    _fill(tissue, **constants)
    if axis:
        frame = ET.SubElement(tissue, "mat_axis", type="vector")
        _fill(frame, a=_row(axis), d=_row(np.eye(3)[np.argmin(np.abs(axis))]))


def _law(material: Material) -> Law:
    """Type of a material in FEBio, its constants [MPa], and the direction of its fibres."""
    laws = {
        "ogden": _ogden,
        "polynomial": _polynomial,
        "foam": _foam,
        "gent": _gent,
        "fibre": _fibres,
    }
    law = laws.get(family(material, "febio") or "")
    if law is None:
        refuse(
            material, "febio", "it has Ogden terms, polynomials in I1 and I2, foams of Poisson's "
            "ratio 0, Gent, or neo-Hooke with fibres",
        )  # fmt: skip
    return law(material)


def _ogden(material: Material) -> Law:
    return "Ogden", _powers(powers(material, "febio", "ogden", MOST_TERMS)), None


def _foam(material: Material) -> Law:
    terms = powers(material, "febio", "foam", MOST_TERMS)
    if any(term.shape[1] > 0.0 for term in terms):
        refuse(material, "febio", "its foam is another one, unless Poisson's ratio is 0")
    return UNCONSTRAINED, {"cp": 0.0, **_powers(terms)}, None


def _gent(material: Material) -> Law:
    if len(material.terms) > 1:
        refuse(material, "febio", "it has one term of Gent")
    (term,) = material.terms
    return "Gent", {"G": term.modulus / MPA, "Jm": term.shape[0]}, None


def _powers(terms: tuple[Term, ...]) -> dict[str, float]:
    """Coefficients of FEBio are twice the moduli."""
    return {
        name: value
        for number, term in enumerate(terms, start=1)
        for name, value in ((f"c{number}", 2.0 * term.modulus / MPA), (f"m{number}", term.shape[0]))
    }


def _polynomial(material: Material) -> Law:
    c10, c01, c20, c30 = (c / MPA for c in polynomial(material))
    if c20 == c30 == 0.0:
        return "Mooney-Rivlin", {"c1": c10, "c2": c01}, None
    if c01:
        refuse(material, "febio", "its Yeoh solid has no second invariant")
    return "Yeoh", {"c1": c10, "c2": c20, "c3": c30}, None


def _fibres(material: Material) -> Law:
    """FEBio has two families at angles of +-gamma, which are one here: half of k1 each."""
    fibre, *more = material.of_law("fibre")
    if more or fibre.shape[2] > 0.0:
        refuse(material, "febio", "it has one direction of fibres, which buckle")
    constants = {
        "c": material.shear_modulus / MPA,
        "k1": 0.5 * fibre.modulus / MPA,
        "k2": fibre.shape[0],
        "kappa": fibre.shape[1],
        "gamma": 0.0,
    }
    return "Holzapfel-Gasser-Ogden", constants, fibre.direction


def _mesh(element: ET.Element, test: StaticTest) -> None:
    """Nodes, elements, sets and surfaces; ids count from one."""
    mesh = test.mesh
    _nodes(element, "sample", test.points, 0)
    starts = len(mesh.points) + np.cumsum([0, *(len(plate.body.points) for plate in test.plates)])
    for first, plate in zip(starts, test.plates, strict=False):
        _nodes(element, plate.name, plate.body.points, int(first))
    _cells(element, "Elements", "elem", mesh.hexes, 0, name="sample", type="hex8")
    elements = len(mesh.hexes)
    for first, plate in zip(starts, test.plates, strict=False):
        corners = first + plate.body.hexes
        _cells(element, "Elements", "elem", corners, elements, name=plate.name, type="hex8")
        elements += len(corners)
    for name, ids in test.sets.items():
        ET.SubElement(element, "NodeSet", name=name).text = _row(ids + 1)
    if test.plates:
        free = np.isin(mesh.boundary_quads, test.boundary.candidates).all(axis=1)
        _cells(element, "Surface", "quad4", mesh.boundary_quads[free], 0, name="free")
    for first, plate in zip(starts, test.plates, strict=False):
        _cells(element, "Surface", "quad4", first + plate.faces, 0, name=f"{plate.name}_face")
        pair = ET.SubElement(element, "SurfacePair", name=f"{plate.name}_pair")
        _fill(pair, primary="free", secondary=f"{plate.name}_face")


def _domains(element: ET.Element, test: StaticTest) -> None:
    """Which material each part is made of; mean dilatation where a law has an isochoric part."""
    foam = family(test.material, "febio") == "foam"
    kind = "elastic-solid" if foam else "three-field-solid"
    ET.SubElement(element, "SolidDomain", name="sample", mat="tissue", type=kind)
    for plate in test.plates:
        ET.SubElement(element, "SolidDomain", name=plate.name, mat=plate.name)


def _boundary(element: ET.Element, test: StaticTest) -> None:
    """Base fixed; the glued nodes displaced, or part of a body that turns."""
    fixed = ET.SubElement(element, "bc", name="base", node_set="BASE", type="zero displacement")
    _fill(fixed, x_dof=1, y_dof=1, z_dof=1)
    if test.angle:
        rigid = ET.SubElement(element, "bc", name="bonded", node_set="BONDED", type="rigid")
        _fill(rigid, rb=TURNED)
    elif not test.plates:
        kind = {"node_set": "BONDED", "type": "prescribed displacement"}
        for axis, value in zip("xyz", test.displacement, strict=True):
            _ramped(ET.SubElement(element, "bc", kind, name=f"bonded_{axis}"), axis, value)


def _rigid(element: ET.Element, test: StaticTest) -> None:
    """Bodies at rest do not move at all; the other is displaced, or turns about its centre."""
    for name, (_, moves) in _bodies(test).items():
        shifted = moves and not test.angle
        fixed = ET.SubElement(element, "rigid_bc", name=f"{name}_fixed", type="rigid_fixed")
        _fill(fixed, rb=name, Rx_dof=not shifted, Ry_dof=not shifted, Rz_dof=not shifted)
        _fill(fixed, Ru_dof=1, Rv_dof=1, Rw_dof=not (moves and test.angle))
        motion = dict(zip("xyz", test.displacement, strict=True)) if shifted else {}
        if moves and test.angle:
            motion = {"Rw": test.angle}
        for dof, value in motion.items():
            kind = "rigid_rotation" if test.angle else "rigid_displacement"
            moved = ET.SubElement(element, "rigid_bc", name=f"{name}_{dof}", type=kind)
            _fill(moved, rb=name)
            _ramped(moved, dof, value)


def _contact(element: ET.Element, test: StaticTest) -> None:
    """Sticky contact, which ties a node to a platen where it met it, or sliding contact."""
    pull = PULL * test.material.shear_modulus / MPA if test.boundary.release else 0.0
    for plate in test.plates:
        sticky = not np.isfinite(plate.friction)
        kind = "sticky" if sticky else "sliding-elastic"
        pair = {"name": plate.name, "type": kind, "surface_pair": f"{plate.name}_pair"}
        contact = ET.SubElement(element, "contact", pair)
        _fill(contact, laugon=0, penalty=test.penalty)
        if sticky:
            _fill(contact, search_tolerance=0.01, max_traction=pull, snap_tol=0.0)
        else:
            _fill(contact, search_tol=0.01, fric_coeff=plate.friction)


def _ramp(element: ET.Element) -> None:
    """The load controller 1: in proportion to time."""
    curve = ET.SubElement(element, "load_controller", id="1", name="ramp", type="loadcurve")
    _fill(curve, interpolate="LINEAR")
    points = ET.SubElement(curve, "points")
    for point in ("0,0", "1,1"):
        ET.SubElement(points, "pt").text = point


def _output(element: ET.Element, test: StaticTest, name: str) -> None:
    """Force of what moves, into a file of its own; fields for the viewers."""
    log = ET.SubElement(element, "logfile")
    record = {"name": "force", "file": f"{name}_force.csv", "delim": ","}
    bodies = _bodies(test)
    for number, (_, moves) in enumerate(bodies.values(), start=TISSUE + 1):
        if moves:
            wanted = "Mx;My;Mz;Fx;Fy;Fz" if test.angle else "Fx;Fy;Fz"
            ET.SubElement(log, "rigid_body_data", record, data=wanted).text = str(number)
    if not bodies:
        ET.SubElement(log, "node_data", record, data="Rx;Ry;Rz", node_set="BONDED")
    plot = ET.SubElement(element, "plotfile", type="febio")
    for variable in ("displacement", "stress", "relative volume"):
        ET.SubElement(plot, "var", type=variable)


def _ramped(element: ET.Element, axis: str, value: float) -> None:
    """One component of a displacement [mm] that grows with the ramp."""
    _fill(element, dof=axis)
    ET.SubElement(element, "value", lc="1").text = _word(value)
    _fill(element, relative=0)


def _nodes(element: ET.Element, name: str, points: Array, first: int) -> None:
    nodes = ET.SubElement(element, "Nodes", name=name)
    for number, point in enumerate(points, start=first + 1):
        ET.SubElement(nodes, "node", id=str(number)).text = _row(point)


def _cells(
    element: ET.Element,
    group: str,
    tag: str,
    corners: NDArray[np.integer],
    first: int,
    **attributes: str,
) -> None:
    cells = ET.SubElement(element, group, attributes)
    for number, row in enumerate(corners + 1, start=first + 1):
        ET.SubElement(cells, tag, id=str(number)).text = _row(row)


def _fill(element: ET.Element, **values: float | str) -> None:
    """Append children `<name>value</name>`."""
    for name, value in values.items():
        ET.SubElement(element, name).text = value if isinstance(value, str) else _word(value)


def _row(values: Iterable[float]) -> str:
    return ",".join(map(_word, values))


def _word(value: float) -> str:
    return f"{value:.10g}"
