"""Figures: axes with units, the lines that should be there, both ways of drawing surfaces."""

import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from softsample.figures import offscreen, render
from softsample.figures.boundary import BASE, GLUED, HeldSample, boundary_figure
from softsample.figures.confusion import confusion_figure
from softsample.figures.contact import contact_figure
from softsample.figures.geometry import SegmentedImage, geometry_figure
from softsample.figures.geometry_effects import effects_figure, prescribed_figure
from softsample.figures.moduli import GroupCurves, limits_of, moduli_figure
from softsample.figures.response import response_figure
from softsample.figures.strain import Deformed, StrainRow, strain_figure
from softsample.figures.stress import stress_strain_figure
from softsample.figures.style import MODE_COLOURS, PALETTE, colours, save
from softsample.figures.surface import (
    FRONT,
    OBLIQUE,
    Surface,
    View,
    level_surface,
    mesh_surface,
    nodal_mean,
    silhouette,
)
from softsample.meshing.cuboid import mesh_cuboid
from softsample.report.geometry_effects import NAMES
from softsample.shapes import Indenter
from softsample.study.plan import MODES

MM = 1e-3


@pytest.fixture
def cuboid():
    return mesh_cuboid(4 * MM, 3 * MM, 2 * MM, 0.5 * MM)


@pytest.fixture
def ball():
    """Signed distance of a ball of 4 mm radius round (0, 0, 2) mm, cut by the base."""
    origin, spacing = np.array([-6.0, -6.0, -2.0]) * MM, 0.5 * MM
    x, y, z = (origin[i] + spacing * np.arange(n) for i, n in enumerate((25, 25, 21)))
    radius = np.sqrt(x[:, None, None] ** 2 + y[None, :, None] ** 2 + (z - 2 * MM) ** 2)
    return radius - 4 * MM, origin, spacing


def labels(figure):
    return [(ax.get_xlabel(), ax.get_ylabel()) for ax in figure.axes if ax.axison]


def moduli(*groups, two_terms=True):
    rows = []
    for group, mode in groups:
        row = {"group": group, "mode": mode, "mu_real_pa": 1000.0, "mu_ideal_pa": 800.0}
        if two_terms:
            row |= {"mu1_real_pa": 700.0, "mu1_ideal_pa": 500.0}
        row |= {"difference_percent": -20.0}
        row |= {"paper_mu_real_pa": 1100.0, "paper_mu_ideal_pa": np.nan}
        rows.append(row)
    return pd.DataFrame(rows)


def curves(*samples):
    n = 201
    return pd.concat(
        pd.DataFrame(
            {
                "sample": name,
                "displacement_mm": np.linspace(0.0, 3.9, n),
                "measured_N": np.linspace(0.0, 1.0, n),
                "model_N": np.linspace(0.0, 1.1, n),
            }
        )
        for name in samples
    )


def group(label, mode, *samples):
    return GroupCurves(label, mode, {g: curves(*samples) for g in ("real", "ideal")})


def test_moduli_figure_draws_every_sample_on_both_geometries():
    groups = [
        group("S1", "shear", "S1"),
        group("S2", "shear", "S2"),
        group("TC1", "tension+compression", "T1", "C1"),
    ]
    table = moduli(*((g.label, g.mode) for g in groups))
    figure = moduli_figure(groups, table)
    shear, shear_left, shear_bars, axial, axial_left, axial_bars = figure.axes
    for ax, left, samples in ((shear, shear_left, 2), (axial, axial_left, 2)):
        points = [line for line in ax.lines if line.get_marker() == "o"]
        model = [line for line in ax.lines if len(line.get_xdata()) == 201]
        assert len(points) == samples
        assert all(len(line.get_xdata()) == 11 for line in points), "ten of 201, and the first"
        assert all(line.get_markerfacecolor() == "none" for line in points), "hollow"
        assert sorted(line.is_dashed() for line in model) == [False] * samples + [True] * samples
        assert ax.get_ylabel() == "Force [N]"
        assert left.get_xlabel() == "Displacement of the platen [mm]"
        assert ax.get_xlim() == left.get_xlim()
        residual = [line for line in left.lines if len(line.get_xdata()) == 50]
        assert sorted(line.is_dashed() for line in residual) == [False] * samples + [True] * samples
        means = residual[0].get_xydata()  # of four or five points; the model is a tenth too high
        assert means[-1] == pytest.approx([3.87075, 9.925])
        assert means[:, 1] == pytest.approx(10.0 / 3.9 * means[:, 0])
    heights = [patch.get_height() for patch in axial_bars.patches]
    assert heights == pytest.approx([0.7, 0.3, 0.5, 0.3])  # mu1, mu2 real; mu1, mu2 ideal [kPa]
    assert [bool(p.get_hatch()) for p in axial_bars.patches] == [False, False, True, True]
    assert axial_bars.get_ylabel() == "Shear modulus [kPa]"
    assert [t.get_text() for t in axial_bars.texts] == ["−20.0 %"]
    assert len([line for line in axial_bars.lines if line.get_marker() == "D"]) == 1, "NaN: none"
    assert len(shear_bars.patches) == 8


def test_bars_have_the_intervals_of_the_table():
    rows = [
        ("S1", "real", "ogden2", "mu", 900.0, 1300.0),
        ("S1", "ideal", "ogden2", "mu", 780.0, 820.0),
        ("S1", "real", "ogden1", "mu", 1.0, 2.0),
        ("S2", "real", "ogden2", "mu", 3.0, 4.0),
        ("S1", "real", "ogden2", "mu1", 5.0, 6.0),
    ]
    names = ["group", "geometry", "model", "modulus", "low_pa", "high_pa"]
    limits = limits_of(pd.DataFrame(rows, columns=names), "S1", "ogden2")
    assert limits == {"real": (900.0, 1300.0), "ideal": (780.0, 820.0)}
    bars = moduli_figure(
        [replace(group("A", "shear", "A"), limits=limits)], moduli(("A", "shear"))
    ).axes[2]
    drawn = [line.get_segments()[0][:, 1] for line in bars.collections]
    assert np.array(drawn) == pytest.approx(np.array([[0.9, 1.3], [0.78, 0.82]]))
    (text,) = bars.texts
    assert text.xy[1] == pytest.approx(1.3), "above the line"


def test_axes_of_torsion_and_indentation_are_named_for_what_moves():
    groups = [group("A", "torsion", "A"), group("B", "indentation", "B")]
    figure = moduli_figure(groups, moduli(("A", "torsion"), ("B", "indentation")))
    (_, torque), (rim, _), _, (_, force), (indenter, _), _ = labels(figure)
    assert (rim, torque) == ("Displacement of the rim [mm]", "Torque over radius [N]")
    assert (indenter, force) == ("Displacement of the indenter [mm]", "Force [N]")


def test_the_difference_stands_below_the_title():
    """A bar that ends where the axis does has it in the title above."""
    table = moduli(("A", "torsion")).assign(mu1_real_pa=1000.0, paper_mu_real_pa=np.nan)
    ax = moduli_figure([group("A", "torsion", "A")], table).axes[2]
    assert ax.get_ylim()[1] >= 1.1


def test_a_fit_that_is_not_trusted_is_marked():
    groups = [group("S1", "shear", "S1"), group("S2", "shear", "S2")]
    groups[1] = replace(groups[1], trusted=False)
    figure = moduli_figure(groups, moduli(("S1", "shear"), ("S2", "shear")))
    assert [t.get_text() for t in figure.axes[2].texts] == ["−20.0 %", "−20.0 % *"]
    keys = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "* see the caption" in keys


def test_moduli_of_ideal_shapes_alone_have_one_bar_and_no_bias():
    groups = [GroupCurves("D", "pure_shear", {"ideal": curves("D1", "D2")})]
    unknown = ("mu_real_pa", "mu1_real_pa", "difference_percent", "paper_mu_real_pa")
    table = moduli(("D", "pure_shear")).assign(**dict.fromkeys(unknown, np.nan))
    figure = moduli_figure(groups, table, "cylinder")
    force, _, bars = figure.axes
    assert force.get_title(loc="left") == r"$\mathbf{a}$  Pure shear: force"
    assert len([line for line in force.lines if line.get_marker() == "o"]) == 2
    assert [patch.get_height() for patch in bars.patches] == pytest.approx([0.5, 0.3])
    assert bars.patches[0].get_x() + 0.5 * bars.patches[0].get_width() == pytest.approx(0.0)
    assert [text.get_text() for text in bars.texts] == ["–"]
    keys = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "model, idealised cylinder" in keys
    assert not [key for key in keys if "real" in key]


def test_the_bias_of_a_mixed_study_is_a_dash_where_it_is_not_known():
    groups = [group("S1", "shear", "S1"), GroupCurves("D", "shear", {"ideal": curves("D1")})]
    table = moduli(("S1", "shear"), ("D", "shear"))
    table.loc[1, ["mu_real_pa", "mu1_real_pa", "difference_percent", "paper_mu_real_pa"]] = np.nan
    bars = moduli_figure(groups, table).axes[2]
    assert [text.get_text() for text in bars.texts] == ["−20.0 %", "–"]


def test_a_record_is_drawn_once_whatever_geometries_there_are():
    for there in (("real", "ideal"), ("ideal",)):
        tables = {geometry: curves("D1") for geometry in there}
        figure = response_figure(tables, "confined_compression", "cylinder")
        shown = [line.get_label() for line in figure.axes[0].lines if line.get_label()[0] != "_"]
        assert shown[0] == "measured"
        assert shown[-1] == "model, idealised cylinder"
        assert len(shown) == 1 + len(there)


def test_one_term_figure_has_one_bar_a_geometry():
    groups = [group("C1", "compression", "C1")]
    figure = moduli_figure(groups, moduli(("C1", "compression"), two_terms=False))
    assert [p.get_height() for p in figure.axes[2].patches] == pytest.approx([1.0, 0.8])


def test_the_picture_of_a_held_out_sample_says_so():
    nothing = curves("D1").iloc[:0]
    force = response_figure({"ideal": nothing}, "tension").axes[0]
    assert [text.get_text() for text in force.texts] == [
        "held out: nothing of this record was calibrated"
    ]
    assert not response_figure({"ideal": curves("D1")}, "tension").axes[0].texts


def test_every_mode_has_a_colour_of_its_own():
    assert len(set(MODE_COLOURS.values())) == len(MODES)
    assert tuple(MODE_COLOURS) == MODES


def test_stress_figure_has_a_line_and_a_band_for_each_mode():
    strain = np.linspace(0.0, 0.3, 4)
    table = pd.concat(
        pd.DataFrame(
            {"mode": mode, "strain": strain, "mean_stress_pa": 2000.0 * strain,
             "sd_stress_pa": 100.0, "count": 5}
        )
        for mode in ("compression", "shear")
    )  # fmt: skip
    figure = stress_strain_figure(table)
    (ax,) = figure.axes
    assert [line.get_label() for line in ax.lines] == ["Shear (n = 5)", "Compression (n = 5)"]
    assert len(ax.collections) == 2
    np.testing.assert_allclose(ax.lines[0].get_ydata(), 2.0 * strain)
    assert labels(figure) == [("Nominal strain, absolute [–]", "Nominal stress, absolute [kPa]")]


@pytest.fixture
def segmented(ball):
    distance, origin, spacing = ball
    to_world = np.eye(4)
    to_world[:3, 3] = [10.0, 10.0, 3.0]
    affine = np.diag([0.5, 0.5, 1.0, 1.0])
    data = np.zeros((40, 40, 14), dtype=np.float32)
    data[12:28, 12:28, 3:9] = 100.0
    return SegmentedImage(data, affine, distance, origin, spacing, to_world)


def test_contour_of_a_slice_lies_on_the_surface(segmented):
    """Voxel (20, 20, 5) is the world point (10, 10, 5) mm, the middle of the ball."""
    middle = np.array([20.0, 20.0, 5.0])
    edge = np.array([28.0, 20.0, 5.0])  # 4 mm further along x
    below = np.array([20.0, 20.0, 2.0])  # 1 mm below the base
    distance = segmented.distance_at(np.array([middle, edge, below]))
    np.testing.assert_allclose(distance, [-2.0, 0.0, 1.0], atol=0.06)


@pytest.mark.parametrize("renderer", ["vtk", "matplotlib"])
def test_geometry_figure(segmented, cuboid, renderer):
    if renderer == "vtk" and not offscreen.rendering_works():
        pytest.skip(offscreen.ADVICE)
    mesh = mesh_surface(cuboid)
    figure = geometry_figure(segmented, (mesh, 192), (mesh, 200), renderer)
    assert labels(figure) == [
        ("image x [mm]", "image y [mm]"),
        ("image x [mm]", "image z [mm]"),
        ("image y [mm]", "image z [mm]"),
    ]
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert titles[4:] == [
        r"$\mathbf{e}$  Real mesh, 192 elements",
        r"$\mathbf{f}$  Idealised mesh, 200 elements",
    ]
    for ax in figure.axes[3:]:
        assert bool(ax.images) == (renderer == "vtk")


def deformed(mesh, displacement_mm, strain, cut=False):
    cells = {"max_principal_hencky_strain": strain}
    return Deformed.of_fields(mesh, {"displacement_mm": displacement_mm}, cells, cut)


@pytest.mark.parametrize("renderer", ["vtk", "matplotlib"])
def test_strain_figure(ball, cuboid, renderer):
    if renderer == "vtk" and not offscreen.rendering_works():
        pytest.skip(offscreen.ADVICE)
    displacement = np.zeros_like(cuboid.points)
    displacement[:, 0] = 0.3 * cuboid.points[:, 2] / MM
    strain = cuboid.points[cuboid.hexes].mean(axis=1)[:, 2] / MM
    shape = deformed(cuboid, displacement, strain)
    both = {"real": shape, "ideal": shape}
    row = StrainRow("S1", "shear", 0.3, level_surface(*ball), both)
    figure = strain_figure([row], renderer)
    before, real, ideal = figure.axes
    (bar,) = ideal.child_axes
    assert bar.get_ylabel() == "Max. principal\nHencky strain [–]"
    assert before.get_ylabel() == "z [mm]"
    assert real.get_xlabel() == "x [mm]"
    assert "nominal strain 0.30" in ideal.get_title(loc="left")
    outline = real.lines[0]
    assert outline.is_dashed()
    np.testing.assert_allclose(outline.get_xdata().max(), 2.0, atol=0.1)
    base, moving = real.patches
    assert base.get_x() == pytest.approx(-2.5)
    assert moving.get_x() + moving.get_width() == pytest.approx(3.1)  # 2 mm, sheared by 0.6 mm
    assert moving.get_x() > base.get_x()
    assert moving.get_y() == pytest.approx(2.0)


def strained(cuboid, mode="tension"):
    strain = cuboid.points[cuboid.hexes].mean(axis=1)[:, 2] / MM
    ideal = deformed(cuboid, np.zeros_like(cuboid.points), strain)
    return StrainRow("D1", mode, 0.3, None, {"ideal": ideal})


def test_strain_of_ideal_shapes_alone_is_one_panel_a_row(cuboid):
    figure = strain_figure([strained(cuboid), strained(cuboid, "pure_shear")], "matplotlib")
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert titles == [
        r"$\mathbf{a}$  Tension, D1: nominal strain 0.30",
        r"$\mathbf{b}$  Pure shear, D1: nominal strain 0.30",
    ]
    assert [ax.get_ylabel() for ax in figure.axes] == ["z [mm]"] * 2


@pytest.mark.parametrize("kind", ["sphere", "flat"])
def test_strain_below_an_indenter_is_shown_in_a_section(cuboid, kind):
    """2 x 2 x 2 mm: of the two halves the one in front, which would hide the indent, is gone."""
    ahead = np.where(cuboid.points[cuboid.hexes].mean(axis=1)[:, 1] < 0.0, 9.0, 0.2)
    cut = deformed(cuboid, np.zeros_like(cuboid.points), ahead, cut=True)
    after, seen = cut.after, np.unique(cut.after.faces)
    assert np.max(after.values[seen]) == pytest.approx(0.2)  # noqa: PD011 - no pandas here
    assert after.points[seen, 1].min() == pytest.approx(0.0, abs=1e-9)
    indenter = Indenter(kind, 0.5 * MM)
    row = StrainRow("I1", "indentation", 0.1, None, {"ideal": cut}, indenter=indenter, tip_mm=1.8)
    (ax,) = strain_figure([row], "matplotlib").axes
    (drawn,) = ax.patches
    box = drawn.get_window_extent().transformed(ax.transData.inverted())
    assert (box.x0, box.x1) == pytest.approx((-0.5, 0.5), abs=0.01)
    assert box.y0 == pytest.approx(1.8, abs=0.01)


def test_strain_of_a_mixed_study_leaves_unknown_panels_blank(ball, cuboid):
    known = strained(cuboid)
    shapes = {"real": known.shapes["ideal"], **known.shapes}
    known = replace(known, sample="S1", surface=level_surface(*ball), shapes=shapes)
    figure = strain_figure([known, strained(cuboid)], "matplotlib")
    assert len(figure.axes) == 6
    titles = [ax.get_title(loc="left") for ax in figure.axes if ax.axison]
    assert titles[0] == r"$\mathbf{a}$  Tension, S1"
    assert titles[3:] == [r"$\mathbf{d}$  Tension, D1: nominal strain 0.30"]


def test_without_rendering_libraries_matplotlib_draws_and_says_what_to_install(monkeypatch, caplog):
    """VTK would end the process; here the child that tries first does."""
    crash = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"
    monkeypatch.setattr(offscreen, "PROBE", crash)
    offscreen.rendering_works.cache_clear()
    try:
        assert render.available_renderer() == "matplotlib"
    finally:
        offscreen.rendering_works.cache_clear()
    assert "libegl1 libgl1-mesa-dri" in caplog.text


def test_painting_needs_no_vtk(cuboid, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    ax = Figure().add_subplot()
    render.draw_surface(ax, mesh_surface(cuboid), FRONT, render.Look(), "matplotlib")
    (faces,) = ax.collections
    assert len(faces.get_paths()) == 8 * 4, "the front of the cuboid, nothing behind it"


def test_painting_hides_what_is_behind():
    """Two squares that face the reader at y = 0 and 1, and one that faces away."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]])
    points = np.vstack([square, square + np.array([0, 1, 0]), square + np.array([0, 2, 0])])
    faces = np.array([[0, 1, 2, 3], [4, 5, 6, 7], [11, 10, 9, 8]])
    ax = Figure().add_subplot()
    look = render.Look(limits=(0.0, 1.0))
    surface = Surface(points, faces, np.repeat([0.0, 1.0, 1.0], 4))
    render.draw_surface(ax, surface, FRONT, look, "matplotlib")
    far, near = ax.collections[0].get_facecolors()
    assert far[1] > 0.7, "the map's yellow, drawn first"
    assert near[1] < 0.1, "the map's violet, drawn over it"


def test_painted_colours_are_those_of_the_colour_bar(cuboid):
    """A surface at the upper limit is drawn in the map's last colour, but for a little shade."""
    shape = mesh_surface(cuboid, element_values=np.full(len(cuboid.hexes), 0.5))
    colour = render._face_colours(shape, render.Look(limits=(0.0, 0.5)))[0]
    assert to_hex(colour) == "#fde725"  # the end of viridis


def test_both_renderers_fill_the_same_area(cuboid, tmp_path):
    """Page coordinates are in mm in either way: the dark pixels must coincide."""
    if not offscreen.rendering_works():
        pytest.skip(offscreen.ADVICE)
    shape = mesh_surface(cuboid)
    image = render.render(shape, OBLIQUE, render.Look(), *_page(shape))
    inside = image[::-1, :, 3] > 127
    outline = silhouette(shape, OBLIQUE, resolution_mm=0.02)
    x, y = outline.T
    area = 0.5 * abs(np.sum(x * np.roll(y, 1) - y * np.roll(x, 1)))
    low, high = _page(shape)
    pixel = np.prod(high - low) / inside.size
    assert inside.sum() * pixel == pytest.approx(area, rel=0.02)
    centre = low + (np.argwhere(inside).mean(axis=0)[::-1] + 0.5) * np.sqrt(pixel)
    np.testing.assert_allclose(centre, OBLIQUE.project(shape.points).mean(axis=0), atol=0.05)


def _page(shape):
    page = OBLIQUE.project(shape.points)
    return page.min(axis=0) - 0.2, page.max(axis=0) + 0.2


def test_segmented_surface_faces_outward_and_ends_at_the_base(ball):
    surface = level_surface(*ball)
    corners = surface.points[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = np.einsum("ij,ij->i", normal, corners.mean(axis=1) - [0.0, 0.0, 2.0])
    assert (outward >= 0.0).all()
    assert outward.sum() > 0.0
    assert surface.points[:, 2].min() == 0.0
    assert surface.points[:, 2].max() == pytest.approx(6.0, abs=0.05)


def test_nodal_mean_is_the_mean_of_the_elements_around(cuboid):
    values = cuboid.points[cuboid.hexes].mean(axis=1)[:, 2]
    mean = nodal_mean(cuboid, values)
    inner = (cuboid.points[:, 2] > 0.0) & (cuboid.points[:, 2] < 2 * MM)
    np.testing.assert_allclose(mean[inner], cuboid.points[inner, 2], atol=1e-12)


def test_silhouette_of_a_cuboid_is_its_front(cuboid):
    outline = silhouette(mesh_surface(cuboid), FRONT, resolution_mm=0.02)
    np.testing.assert_allclose(outline.min(axis=0), [-2.0, 0.0], atol=0.03)
    np.testing.assert_allclose(outline.max(axis=0), [2.0, 2.0], atol=0.03)


def test_views_are_orthonormal_and_look_from_the_front():
    for view in (FRONT, OBLIQUE, View.from_angles(200.0, -40.0)):
        frame = np.array([view.right, view.up, view.towards_eye])
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(FRONT.towards_eye, [0.0, -1.0, 0.0])
    np.testing.assert_allclose(
        View.from_angles(0.0, 0.0).project(np.eye(3)), FRONT.project(np.eye(3))
    )
    assert OBLIQUE.towards_eye[2] > 0.0


def test_groups_have_different_colours():
    assert colours(5) == list(PALETTE[:5])
    assert len(set(colours(20))) == 20


@pytest.mark.parametrize("kind", ["png", "pdf"])
def test_a_figure_is_written_with_the_same_bytes_every_time(tmp_path, kind):
    groups = [group("C1", "compression", "C1")]
    table = moduli(("C1", "compression"), two_terms=False)
    for name in ("a", "b"):
        save(moduli_figure(groups, table), tmp_path / f"{name}.{kind}")
    first, second = ((tmp_path / f"{name}.{kind}").read_bytes() for name in ("a", "b"))
    assert first == second
    assert len(first) > 1000


def test_a_surface_without_limits_spans_its_own_values():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]])
    both = np.vstack([square, square + np.array([2.0, 0.0, 0.0])])
    faces = np.array([[0, 1, 2, 3], [4, 5, 6, 7]])
    surface = Surface(both, faces, np.repeat([1.0, 3.0], 4))
    ends = [to_hex(c) for c in render._face_colours(surface, render.Look())]
    assert ends == ["#440154", "#fde725"]


def held_samples(cuboid, *modes):
    modes = modes or ("shear", "tension", "compression")
    top = cuboid.glued(0.0)
    return [HeldSample(name[0].upper(), name, "ideal", cuboid, top) for name in modes]


def test_boundary_conditions_show_what_is_fixed_glued_and_pressed(cuboid):
    figure = boundary_figure(held_samples(cuboid), "matplotlib")
    dots = [[to_hex(c.get_facecolor()[0]) for c in ax.collections[1:]] for ax in figure.axes]
    assert dots == [[to_hex(BASE), to_hex(GLUED)], [to_hex(BASE), to_hex(GLUED)], [to_hex(BASE)]]
    assert [len(ax.patches) for ax in figure.axes] == [0, 0, 1]  # the platen
    glued = figure.axes[0].collections[2].get_offsets()
    assert len(glued) == len(cuboid.glued(0.0))  # the whole top is turned to the eye
    moves = [text.xy[1] - text.xyann[1] for ax in figure.axes for text in ax.texts]
    assert moves[1] > 0.0 > moves[2]


@pytest.mark.parametrize("kind", ["sphere", "flat"])
def test_an_indenter_stands_on_the_top(cuboid, kind):
    (held,) = held_samples(cuboid, "indentation")
    indenter = Indenter(kind, 0.5 * MM)
    (ax,) = boundary_figure([replace(held, indenter=indenter)], "matplotlib").axes
    (outline,) = ax.patches
    corners = outline.get_xy()
    assert np.ptp(corners[:, 0]) == pytest.approx(1.0, rel=0.01)
    lowest = OBLIQUE.project(np.array([[0.0, 0.0, 2.0]]))[0, 1]
    if kind == "sphere":  # its shadow is a circle, of its radius about its centre
        middle = OBLIQUE.project(np.array([[0.0, 0.0, 2.5]]))[0, 1]
        assert corners[:, 1].min() == pytest.approx(middle - 0.5, rel=0.01)
    else:
        assert corners[:, 1].min() < lowest < corners[:, 1].max()


def test_boundary_conditions_of_a_mixed_study_leave_unknown_geometries_blank(cuboid):
    tension, pressed = (
        HeldSample(mode, mode, "ideal", cuboid, cuboid.glued(0.0))
        for mode in ("tension", "compression")
    )
    held = [replace(tension, geometry="real"), tension, pressed]
    figure = boundary_figure(held, "matplotlib")
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert titles == [
        r"$\mathbf{a}$  Tension, tension, real", "",
        r"$\mathbf{b}$  Tension, tension, idealised",
        r"$\mathbf{c}$  Compression, compression, idealised",
    ]  # fmt: skip
    assert [len(ax.patches) for ax in figure.axes] == [0, 0, 0, 1]


def test_contact_areas_have_a_line_for_each_geometry():
    curve = pd.DataFrame({"strain": [0.0, 0.3], "share_percent": [0.0, 90.0]})
    figure = contact_figure({("C1", "real"): curve, ("C1", "ideal"): curve})
    (ax,) = figure.axes
    assert [line.get_linestyle() for line in ax.lines] == ["-", "--"]
    (alone,) = contact_figure({("C1", "ideal"): curve}, "cylinder").axes
    assert [t.get_text() for t in alone.get_legend().get_texts()] == ["C1", "idealised cylinder"]
    assert "[–]" in ax.get_xlabel()
    assert "[%]" in ax.get_ylabel()


def test_effects_have_a_point_for_each_experiment_and_a_line_at_the_papers_mean():
    rows = [
        {"terms": 2, "mode": "shear", "sample_variant": sample, "model_variant": "cuboid",
         "bias_percent": bias, "bias_sd_percent": np.nan}
        for sample, bias in (("real", -6.0), ("levelled", -2.0))
    ]  # fmt: skip
    needed = pd.DataFrame({"terms": [2], "mode": ["shear"], "paper_percent": [-10.0]})
    (ax,) = effects_figure(pd.DataFrame(rows), needed).axes
    points = [line.get_xdata()[0] for line in ax.lines if line.get_marker() in ("s", "o")]
    assert points == [-6.0, -2.0]
    assert [text.get_text() for text in ax.get_yticklabels()] == [
        "as in the study", "sample: top levelled",
    ]  # fmt: skip
    lines = [line.get_xdata()[0] for line in ax.lines if line.get_linestyle() in (":", "--")]
    assert lines == [-6.0, -10.0]
    (alone,) = effects_figure(pd.DataFrame(rows), needed.iloc[:0]).axes
    assert not [line for line in alone.lines if line.get_linestyle() == ":"]


def test_curves_that_part_are_marked():
    curve = pd.DataFrame({"strain": [0.0, 0.3], "contact_N": [0.0, 1.0], "prescribed_N": [0.0, 2]})
    curves = {("C1", "real"): curve, ("C1", "ideal"): curve}
    table = pd.DataFrame(
        {"sample": "C1", "geometry": ["real", "ideal"], "agrees_5_percent_strain": [0.15, 0.3]}
    )
    marks = [
        [line.get_xydata().tolist() for line in ax.lines if line.get_marker() == "o"]
        for ax in prescribed_figure(curves, table).axes
    ]
    assert marks == [[[[0.15, 0.5]]], []]


def test_ground_truth_is_on_one_axis_for_all_discrepancies():
    share = {"nothing": [0.0, 0.0], "late_contact": [0.0, 1.0], "none": [1.0, 0.0]}
    table = pd.concat(
        pd.DataFrame(
            {"design": "B", "floor_percent": floor, "planted": ["nothing", "late_contact"], **share}
        )
        for floor in (0.0, 1.0)
    )
    figure = confusion_figure(table)
    width, height = figure.get_size_inches()
    assert height < width
    assert [ax.get_ylabel() for ax in figure.axes] == ["ground truth", ""]
    assert [ax.get_title() for ax in figure.axes] == [
        f"model discrepancy {floor} % of peak" for floor in (0, 1)
    ]


def overlapping(figure, texts):
    """Pairs of texts that are drawn over each other."""
    renderer = figure.canvas.get_renderer()
    figure.draw(renderer)
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in texts]
    return [
        (one, other)
        for k, (one, box) in enumerate(boxes)
        for other, beside in boxes[k + 1 :]
        if one and other and box.overlaps(beside)
    ]


def test_titles_of_effects_stand_beside_each_other():
    rows = [
        {"terms": terms, "mode": mode, "sample_variant": sample, "model_variant": model,
         "bias_percent": -40.0, "bias_sd_percent": 5.0}
        for terms, mode in ((2, "shear"), (2, "tension+compression"), (1, "compression"))
        for sample, model in NAMES
    ]  # fmt: skip
    needed = pd.DataFrame(columns=["terms", "mode", "paper_percent"])
    figure = effects_figure(pd.DataFrame(rows), needed)
    titles = [t for t in figure.findobj(Text) if t.get_text().endswith("-term model")]
    assert len(titles) == 3
    assert overlapping(figure, titles) == []
