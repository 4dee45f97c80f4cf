"""Arrows of the architecture, read from the imports: one direction, and few doors."""

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted((ROOT / "src/softsample").rglob("*.py"))
SCRIPTS = sorted((ROOT / "workflow/scripts").glob("*.py"))

MECHANICS = {"errors", "meshing", "constitutive", "fem", "shapes"}

BASICS = {"arrays", "units"}
"""Names of types and units: they import nothing of the package, and all of it may import them."""

ALLOWED = {
    "arrays": set(),
    "units": set(),
    "errors": set(),
    "shapes": {"errors"},
    "meshing": {"errors", "shapes"},
    "imaging": {"errors", "meshing", "shapes"},
    "constitutive": {"errors"},
    "protocol": {"errors"},
    "validation": {"errors", "shapes"},
    "images": {"errors"},
    "progress": set(),
    "wording": set(),
    "record_noise": set(),
    "lone": {"protocol"},
    "records": {"errors", "lone", "protocol", "validation"},
    "plausibility": {"errors", "files", "formats", "protocol", "records", "wording"},
    "holdout": {"errors", "records", "validation"},
    "files": {"errors"},
    "presence": {"errors", "files"},
    "workflow": {"errors", "files", "progress"},
    "manifest": {"errors", "files"},
    "costs": {"errors", "workflow"},
    "dependencies": {"workflow"},
    "formats": {"errors", "files"},
    "io": {"errors", "files", "formats", "meshing", "records", "shapes"},
    "fem": {"errors", "meshing", "constitutive", "protocol", "shapes"},
    "response": {"protocol"} | MECHANICS,
    "calibration": {
        "errors", "protocol", "records", "holdout", "constitutive", "fem", "response",
    },
    "laws": {
        "calibration", "constitutive", "errors", "fem", "holdout", "protocol", "records",
        "response", "shapes", "record_noise",
    },
    "loop": {
        "constitutive", "holdout", "protocol", "records", "response", "shapes", "record_noise",
    },
    "geometry_effects": {"calibration", "protocol", "response"} | MECHANICS,
    "checks": {"errors", "fem", "meshing"},
    "scoring": {"calibration", "records", "response", "record_noise"},
    "report": {"errors", "loop", "protocol", "response", "wording"},
    "blindlab": {"calibration", "loop", "protocol", "records", "response"} | MECHANICS,
    "export": {"errors", "meshing", "constitutive", "fem", "io"},
    "figures": {"files", "loop", "meshing", "protocol", "report", "shapes", "wording"},
    "study": {
        "errors", "formats", "holdout", "images", "imaging", "io", "meshing", "plausibility",
        "presence", "protocol", "records", "shapes", "validation",
    },
    "measured": {"errors", "figures", "files", "io", "report", "study"},
    "from_files": {
        "calibration", "constitutive", "figures", "imaging", "io", "loop", "records", "report",
        "response", "shapes",
    },
    "inspection": {"figures", "plausibility", "records", "report", "study"},
    "__main__": {"errors", "figures", "formats", "inspection", "io", "study"},
    "__init__": set(),
}  # fmt: skip
"""What each part of the package may import, and nothing else of it."""


def imports(path):
    """Names that a file imports, with the softsample ones in full."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import in line {node.lineno}"
            yield str(node.module)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def part(path):
    """Part of the package that a file belongs to: its folder, or its own name."""
    return path.relative_to(ROOT / "src/softsample").parts[0].removesuffix(".py")


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(ROOT / "src")))
def test_imports_point_one_way(path):
    inner = {
        name.split(".")[1] if "." in name else "__init__"
        for name in imports(path)
        if name.split(".")[0] == "softsample"
    } - {part(path), "__init__"}
    assert "snakemake" not in {name.split(".")[0] for name in imports(path)}
    assert inner <= ALLOWED[part(path)] | BASICS
    if part(path) not in ("__main__", "export", "from_files", "inspection", "measured", "study"):
        assert not inner & {"io", "figures"}


def test_the_arrows_have_no_cycle():
    order = list(TopologicalSorter(ALLOWED).static_order())
    places = [order.index(name) for name in ("constitutive", "fem", "response", "calibration")]
    assert places == sorted(places)
    assert order.index("records") < order.index("holdout") < order.index("loop")
    for solver in ("constitutive", "fem", "response"):
        assert not ALLOWED[solver] & {"records", "holdout", "calibration", "loop"}


def test_no_arrow_is_allowed_that_no_file_needs():
    used = {(part(path), name.split(".")[1]) for path in SOURCES for name in imports(path)
            if name.startswith("softsample.")}  # fmt: skip
    allowed = {(name, other) for name, others in ALLOWED.items() for other in others}
    assert allowed <= used


def test_scripts_only_adapt():
    for path in SCRIPTS:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        kinds = {type(node) for node in ast.walk(tree)}
        assert not kinds & {ast.FunctionDef, ast.ClassDef}, f"{path.name} defines; the library may"
        assert ast.get_docstring(tree), path.name
        assert "with logged_to(snakemake):" in path.read_text(encoding="utf-8"), path.name


def test_scripts_are_short():
    assert not [p.name for p in SCRIPTS if len(p.read_text(encoding="utf-8").splitlines()) > 30]


def test_only_scoring_knows_of_the_truth():
    files = [
        *SOURCES,
        *SCRIPTS,
        ROOT / "workflow/Snakefile",
        *sorted((ROOT / "workflow/rules").glob("*")),
    ]
    naming = {p.name for p in files if re.search(r"truth", p.read_text(encoding="utf-8"), re.I)}
    assert naming == {
        "confusion.py",  # a figure of what score.py has found
        "known.py",
        "scoring.py",
        "score.py",
        "score_verdicts.py",
        "recovery.py",
        "scoring.smk",
    }


def test_the_blind_laboratory_shares_nothing_with_the_effects():
    """Makers of records know nothing of the loop, and those of verdicts none of its effects."""
    knowing = {"judge.py", "models.py", "resample.py"}
    for path in (ROOT / "src/softsample/blindlab").glob("*.py"):
        of_loop = {name for name in imports(path) if name.startswith("softsample.loop")}
        assert path.name in knowing or not of_loop, path.name
        assert "loop.effects" not in path.read_text(encoding="utf-8")


def test_phantoms_share_nothing_with_the_segmentation_that_they_judge():
    shapes = ROOT / "src/softsample/blindlab/phantom.py"
    for path in [shapes, *(ROOT / "benchmarks/phantom").glob("*.py")]:
        known = {name for name in imports(path) if name.startswith("softsample.")}
        assert known <= {"softsample.arrays", "softsample.blindlab.phantom"}, path.name


def test_only_the_report_reads_values_of_the_paper():
    naming = {
        path.name
        for path in sorted((ROOT / "workflow/rules").glob("*"))
        if "resources/paper" in path.read_text(encoding="utf-8") or "PAPER" in path.read_text()
    }
    assert naming == {"common.smk", "report.smk", "geometry_effects.smk"}
