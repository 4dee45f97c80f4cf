"""What was found of one sample on its way through the workflow, in words."""

from collections.abc import Mapping, Sequence

from softsample.report.html import written
from softsample.report.results import Report
from softsample.report.tables import doubt_of
from softsample.wording import NO_ERROR, distrusted


def sample_facts(
    record: Report,
    image: Report | None,
    segmentation: Report | None,
    cuboid: Report,
    mesh: Mapping[str, Report],
    run: Mapping[str, Report],
) -> list[tuple[str, str]]:
    """Name and value of each row of the table that opens a sample's page.

    Parameters
    ----------
    record, image
        What was found in each (`inputs/{sample}.json` and `inputs/images/{sample}.json`).
    segmentation, cuboid
        `segmentation/` and `cuboid/{sample}.json`; no segmentation of a sample whose dimensions
        are stated.
    mesh, run
        `mesh/` and `fields/{sample}/{geometry}.json` by geometry.
    """
    rows = [("Record", record_fact(record)), _ideal(cuboid)]
    if segmentation:
        rows.insert(1, ("Surface", _surface(segmentation, image is not None)))
    if image:
        voxels = f"{_by(image['shape'], 'voxels')} of {_by(image['voxel_mm'], 'mm')}"
        rows.insert(0, ("Image", voxels))
    rows.append(("Meshes", "; ".join(_mesh(name, report) for name, report in mesh.items())))
    runs = (
        f"{name}: nominal strain {written(report['travel_mm'] / cuboid['height_mm'])}, "
        f"{written(report['against_calibrated_curve_percent'])} % of peak from the calibrated curve"
        for name, report in run.items()
    )
    rows.append(("Run at the optimum", "; ".join(runs)))
    remarks = [*record["warnings"], *(segmentation or {}).get("flags", [])]
    return rows + ([("Remarks", "; ".join(remarks))] if remarks else [])


def record_fact(record: Report) -> str:
    """What was found in a test record; one without time has neither rate nor speed."""
    rate, speed = record.get("sampling_rate_hz"), record.get("ramp_speed_mm_s")
    phases = ", ".join(phase["kind"] for phase in record["phases"])
    return (
        f"{record['samples']} points{_given(' at {} Hz', rate)}; displacement "
        f"{written(record['travel_mm'])} mm,{_given(' ramp {} mm/s,', speed)} "
        f"peak {written(record['peak_force_N'])} N, noise "
        f"{written(record['force_noise_N'])} N; {phases}"
    )


def _given(text: str, value: float | None) -> str:
    """`text` with the value, nothing without one."""
    return "" if value is None else text.format(written(value))


def _surface(segmentation: Report, imaged: bool) -> str:
    """Volume of the sample, and what was done to the segmentation of an image."""
    volume = f"{written(segmentation['volume_mm3'])} mm³"
    if not imaged:
        return f"{volume}, as given"
    return (
        f"{volume}, known to "
        f"{written(segmentation['boundary_sigma_mm'])} mm (one sigma); film of "
        f"{written(segmentation['film_mm'])} mm corrected for, tilt of "
        f"{written(segmentation['tilt_deg'])}° too"
    )


def _ideal(cuboid: Report) -> tuple[str, str]:
    """Kind and size of the idealised shape, and how the sample's faces differ from it."""
    if "diameter_mm" in cuboid:
        kind, height = "Cylinder", written(cuboid["height_mm"])
        size = f"diameter {written(cuboid['diameter_mm'])} mm, height {height} mm"
    else:
        kind, edges = "Cuboid", ("length_mm", "width_mm", "height_mm")
        size = _by([cuboid[edge] for edge in edges], "mm")
    if "top_difference_percent" not in cuboid:
        unknown = "as stated; the sample's true shape, and with it the bias, is not known"
        return kind, f"{size}, {unknown}"
    return kind, (
        f"{size}; faces of the sample against it: bottom "
        f"{written(cuboid['bottom_difference_percent'])} %, top "
        f"{written(cuboid['top_difference_percent'])} %"
    )


def _by(sizes: Sequence[float], unit: str) -> str:
    return f"{' × '.join(written(size) for size in sizes)} {unit}"


def _mesh(name: str, report: Report) -> str:
    quality = written(report["min_scaled_jacobian"])
    return f"{name}: {report['elements']} hexahedra, scaled Jacobian {quality} at least"


def spoken_effect(name: str) -> str:
    """Name of an effect in words."""
    return "sliding ends" if name == "ends" else name.replace("_", " ")


def verdict_sentence(verdict: Report) -> str:
    """Which effects a verdict names, and the error before and after, largest of the tests.

    Why it is not to be trusted comes first.
    """
    sets = ([spoken_effect(name) for name in effect["class"]] for effect in verdict["effects"])
    effects = "; ".join(map(" or ".join, sets))
    before, after = (
        max(phases["all"]["rms_percent_structured"] for phases in verdict[f"error_{when}"].values())
        for when in ("before", "after")
    )
    named = f"Effects: {effects}. " if effects else ""
    warned = "".join(
        f"{title}: {samples}. {cure} " for title, (samples, cure) in distrusted(verdict).items()
    )
    return (
        f"{warned}{named}Error, noise taken out, of the test with the largest: {_of_peak(before)} "
        f"before, {_of_peak(after)} after."
    )


def _of_peak(percent: float) -> str:
    return f"{written(percent)} % of peak" if percent >= NO_ERROR else "less than the noise"


def findings_of(fits: Sequence[Report]) -> list[str]:
    """What the calibrations of a group found beside their moduli, a sentence each."""
    return [
        f"{fit['geometry']} geometry, {fit['model']}: {doubt}"
        for fit in fits
        if (doubt := doubt_of(fit))
    ]
