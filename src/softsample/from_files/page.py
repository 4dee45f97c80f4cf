"""The report of a study, from its files."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from softsample.calibration.slsqp import STARTS_PER_PARAMETER
from softsample.figures.strain import moved_surface
from softsample.figures.style import map_colours
from softsample.imaging.tissue import BIAS_ORDER, FLUID_RATIO, SMOOTHING_MM
from softsample.io import read_json, read_mesh_with_data, read_table, read_yaml
from softsample.report.study import StudyReport, by_name

Files = Mapping[str, Any]
"""A file or a list of files by name, as Snakemake gives the input of a rule."""


def report_page(files: Files, shown: Any, own: Mapping[str, Any]) -> str:
    """The report of a study, a page in HTML.

    Parameters
    ----------
    files : mapping
        Input of the rule `page`.
    shown : object
        Its parameters.
    own : mapping
        Versions and checksum of the settings, as of `softsample.workflow.provenance`.
    """
    return _study_report(files, shown).page(
        Path(files["template"]),
        document=read_json(files["document"]),
        tables=by_name(map(Path, files["tables"]), map(read_table, files["tables"])),
        figures=[*map(Path, files["figures"])],
        checks={Path(name).stem: read_json(name)["checks"] for name in files["checks"]},
        schema=read_yaml(files["schema"]),
        colours=map_colours(),
        references=read_yaml(files["references"]),
        cohort=shown.cohort,
        ideal=shown.ideal,
        left_out=shown.left_out,
        failures=shown.failures,
        versions=own["versions"],
        settings_sha256=own["settings_sha256"],
        constants={
            "bias_order": BIAS_ORDER,
            "smoothing_mm": SMOOTHING_MM,
            "fluid_ratio": FLUID_RATIO,
            "starts_per_parameter": STARTS_PER_PARAMETER[shown.config["calibration"]["method"]],
        },
    )


def _study_report(files: Files, shown: Any) -> StudyReport:
    """What the files of a study hold."""
    runs = [*map(tuple, shown.runs)]
    surfaces = [moved_surface(*read_mesh_with_data(name)) for name in files["fields"]]
    return StudyReport(
        rows=shown.samples,
        groups=shown.groups,
        piece_of=shown.piece_of,
        images=_reports(shown.segmented, files["images"]),
        records=_reports(shown.samples, files["records"]),
        segmentation=_reports(shown.segmented, files["segmentation"]),
        cuboid=_reports(shown.piece_of.values(), files["cuboid"]),
        meshes=_reports(runs, files["mesh"]),
        runs=_reports(runs, files["run"]),
        surfaces=by_name(runs, surfaces),
        pictures={k: by_name(names, map(Path, files[k])) for k, names in shown.pictured.items()},
        fits=[*map(read_json, files["fits"])],
        verdicts=_reports(shown.groups, files["verdict_json"]),
        verdict_pages=by_name(shown.groups, map(Path, files["verdict_md"])),
        verdict_plots=by_name(shown.groups, map(Path, files["verdict_png"])),
        intervals=read_table(files["intervals"]),
        parts=Path(files["template"]).parent,
        config=shown.config,
    )


def _reports(names: Iterable[Any], paths: Sequence[Any]) -> dict[Any, Any]:
    """Content of JSON files by name."""
    return by_name(names, map(read_json, paths))
