"""The page of `softsample check`: what the program understood of each sample, to be looked at."""

from collections.abc import Iterator
from io import BytesIO

import numpy as np
from markupsafe import Markup

from softsample.figures.geometry import Scan, SegmentedImage
from softsample.figures.inspected import inspected_figure
from softsample.figures.style import save
from softsample.figures.surface import Surface
from softsample.plausibility import figures
from softsample.records import Record
from softsample.report.html import picture, render_report
from softsample.study import ROOT
from softsample.study.check import Inspection
from softsample.study.compare import Seen
from softsample.units import MM

TEMPLATE = ROOT / "workflow/report/check.html.j2"

PER_STIFFNESS = {
    "tension": 3.0,
    "compression": 3.0,
    "pure_shear": 4.0,
    "shear": 1.0,
    "torsion": 0.5,
}
"""Nominal stress over strain of an incompressible sample with sliding ends, in shear moduli; in
torsion torque over radius and section, over the strain of the rim."""

EARLY = 1.0 / 3.0
"""Part of the way that is taken for the slope at the start."""

DOTS_PER_INCH = 110


def check_page(result: Inspection, name: str) -> str:
    """HTML of one page, with nothing outside itself.

    Parameters
    ----------
    result
        What was found in a study.
    name
        Of the study.
    """
    samples = [
        {
            "name": one.row.get("sample", "?"),
            "mode": one.row.get("mode", "?").replace("_", " "),
            "picture": _picture(one),
            "numbers": list(_numbers(one)),
            "found": "\n".join(one.found[1:]),
            "faults": _of(one, result.faults),
            "doubts": _of(one, result.doubts),
        }
        for one in result.seen
    ]
    places = tuple(one.where for one in result.seen)
    general = [line for line in (*result.faults, *result.doubts) if not line.startswith(places)]
    return render_report(
        TEMPLATE,
        name=name,
        samples=samples,
        general=general,
        faults=len(result.faults),
        doubts=len(result.doubts),
    )


def _of(one: Seen, messages: list[str]) -> list[str]:
    """Messages on a row, without the place."""
    return [
        line.removeprefix(one.where).lstrip(":, ")
        for line in messages
        if line.startswith(one.where)
    ]


def _numbers(one: Seen) -> Iterator[tuple[str, str]]:
    """What to compare with what is known of the test: name and value with unit."""
    if one.facts is None:
        return
    found = figures(one.facts, one.size)
    if "strain" in found:
        yield "strain that is reached", f"{100.0 * found['strain']:.3g} %"
    if "strain_rate_per_s" in found:
        yield "strain rate", f"{found['strain_rate_per_s']:.2g} per s"
    if one.record is not None and one.size is not None and one.row.get("mode") in PER_STIFFNESS:
        slope = _first_slope(one.record) * one.size.height / one.size.area
        modulus = slope / PER_STIFFNESS[one.row["mode"]]
        yield "shear modulus, roughly", f"{float(f'{modulus:.2g}'):g} Pa"


def _first_slope(record: Record) -> float:
    """Force over displacement [N/m] in the first third of what is calibrated."""
    moved, force = (x[record.calibrated] for x in (record.displacement, record.force))
    way, more = moved - moved[0], force - force[0]
    early = np.abs(way) <= EARLY * np.abs(way).max()
    early |= not way[early].any()  # of a few readings
    return float(way[early] @ more[early] / (way[early] @ way[early]))


def scan(one: Seen) -> Scan | None:
    """The image of a sample at low resolution, if it was read; with what was segmented in it."""
    if one.image is None or one.glance is None:
        return Scan(*one.image) if one.image else None
    (data, affine), found = one.image, one.glance.found
    to_world = found.sample_to_world.copy()
    to_world[:3, 3] /= MM
    return SegmentedImage(data, affine, found.distance, found.origin, found.spacing, to_world)


def _picture(one: Seen) -> Markup | str:
    """The figure of a sample; empty if nothing could be read."""
    if one.record is None and one.image is None and one.surface is None:
        return ""
    image, surface = scan(one), None
    if isinstance(image, SegmentedImage):
        surface = image.surface()
    elif one.surface is not None:
        surface = Surface(one.surface.points / MM, one.surface.triangles)
    record = None
    if one.record is not None:
        record = (one.record.displacement / MM, one.record.force, one.record.calibrated)
    drawn = inspected_figure(one.row.get("mode", ""), record, one.size, surface, image)
    buffer = BytesIO()
    save(drawn, buffer, DOTS_PER_INCH)
    return picture(buffer, f"{one.row.get('sample', '?')}: sections, outline and record")
