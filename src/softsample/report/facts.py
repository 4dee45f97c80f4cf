"""What was found of one sample on its way through the workflow, in words."""

from collections.abc import Mapping, Sequence
from typing import Any

from softsample.report.html import written

Report = Mapping[str, Any]


def sample_facts(
    found: Report, segmentation: Report, cuboid: Report, mesh: Report, run: Report
) -> list[tuple[str, str]]:
    """Name and value of each row of the table that opens a sample's page.

    Parameters
    ----------
    found, segmentation, cuboid
        `inputs/`, `segmentation/` and `cuboid/{sample}.json`.
    mesh, run
        `mesh/` and `fields/{sample}/{geometry}.json` by geometry.
    """
    record = found["record"]
    phases = ", ".join(phase["kind"] for phase in record["phases"])
    edges = _by([cuboid[f"{edge}_mm"] for edge in ("length", "width", "height")], "mm")
    image = found["image"]
    rows = [
        ("Image", f"{_by(image['shape'], 'voxels')} of {_by(image['voxel_mm'], 'mm')}"),
        (
            "Record",
            f"{record['samples']} points at {written(record['sampling_rate_hz'])} Hz; travel "
            f"{written(record['travel_mm'])} mm, ramp {written(record['ramp_speed_mm_s'])} mm/s, "
            f"peak {written(record['peak_force_N'])} N, noise "
            f"{written(record['force_noise_N'])} N; {phases}",
        ),
        (
            "Surface",
            f"{written(segmentation['volume_mm3'])} mm³, known to "
            f"{written(segmentation['boundary_sigma_mm'])} mm (one sigma); film of "
            f"{written(segmentation['film_mm'])} mm taken off, tilt of "
            f"{written(segmentation['tilt_deg'])}° taken out",
        ),
        (
            "Cuboid",
            f"{edges}; faces of the sample against it: bottom "
            f"{written(cuboid['bottom_difference_percent'])} %, top "
            f"{written(cuboid['top_difference_percent'])} %",
        ),
        ("Meshes", "; ".join(_mesh(name, report) for name, report in mesh.items())),
        (
            "Run at the optimum",
            "; ".join(
                f"{name}: nominal strain {written(report['travel_mm'] / cuboid['height_mm'])}, "
                f"{written(report['against_calibrated_curve_percent'])} % of peak from the "
                "calibrated curve"
                for name, report in run.items()
            ),
        ),
    ]
    remarks = [*record["warnings"], *segmentation["flags"]]
    return rows + ([("Remarks", "; ".join(remarks))] if remarks else [])


def _by(sizes: Sequence[float], unit: str) -> str:
    return f"{' × '.join(written(size) for size in sizes)} {unit}"


def _mesh(name: str, report: Report) -> str:
    quality = written(report["min_scaled_jacobian"])
    return f"{name}: {report['elements']} hexahedra, scaled Jacobian {quality} at least"


def verdict_sentence(verdict: Report) -> str:
    """Which effects a verdict names, and the error before and after, largest of the tests."""
    effects = "; ".join(" or ".join(effect["class"]) for effect in verdict["effects"])
    before, after = (
        max(phases["all"]["rms_percent_structured"] for phases in verdict[f"error_{when}"].values())
        for when in ("before", "after")
    )
    named = f"Effects: {effects.replace('_', ' ')}. " if effects else ""
    return (
        f"{named}Error, noise taken out, of the test with the largest: {written(before)} % of peak "
        f"before, {written(after)} % after."
    )
