"""One builder of the response and one function that predicts a record, read from the code."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src/softsample"
SCRIPTS = ROOT / "workflow/scripts"
FILES = [*sorted(PACKAGE.rglob("*.py")), *sorted(SCRIPTS.glob("*.py"))]


def name_of(path):
    """Its place in the package, or that of a script."""
    return str(path.relative_to(PACKAGE if path.is_relative_to(PACKAGE) else SCRIPTS.parent))


@cache
def tree_of(path):
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def calls_in(path):
    """Calls of a file, each with the innermost function that it stands in."""
    functions = [(place, node) for place, node in places(tree_of(path))
                 if isinstance(node, ast.FunctionDef)]  # fmt: skip
    found = []
    for call in ast.walk(tree_of(path)):
        if isinstance(call, ast.Call):
            inside = [p for p, node in functions if node.lineno <= call.lineno <= node.end_lineno]
            found.append((called(call), inside[-1] if inside else ""))
    return found


def called(node):
    """Name of the function or method that a call calls."""
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


def places(tree, prefix=""):
    """Functions and methods of a file with their names, `Class.method`; the innermost last."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            place = f"{prefix}{node.name}"
            yield place, node
            yield from places(node, f"{place}.")


def callers(function, within=FILES):
    """Files, and functions in them, that call a function or method of a name."""
    return {
        (name_of(path), place)
        for path in within
        for name, place in calls_in(path)
        if name == function
    }


def definitions(function, within=FILES):
    """Files, and functions or methods in them, that have a name."""
    return {
        (name_of(path), place)
        for path in within
        for place, node in places(tree_of(path))
        if isinstance(node, ast.FunctionDef) and place.split(".")[-1] == function
    }


def in_part(found, part):
    return {(path, place) for path, place in found if path.startswith(part)}


def test_solids_of_unit_modulus_are_run_by_one_function():
    """Others that make such a solid hand it to it, or make records, or are told the modulus."""
    makers = callers("unit_modulus")
    assert {path for path, _ in makers if not path.startswith("response/")} == {
        "blindlab/curves.py",  # maker of records
        "blindlab/models.py",  # runs by unit_runs
        "calibration/direct.py",  # the modulus that SLSQP tries
        "geometry_effects/variants.py",  # runs by unit_runs
        "loop/effects/base.py",  # exponents of the study, nothing is run
    }
    assert callers("unit_runs") == {
        ("blindlab/models.py", "_curves"),
        ("geometry_effects/variants.py", "ShapeTest.simulate"),
        ("laws/simulate.py", "SimulatedResponse.simulate"),
        ("response/unit.py", "simulated_response"),
    }


def test_a_response_has_one_builder_and_its_closed_form():
    for used in ("simulated_response", "homogeneous_response", "response_table"):
        assert callers(used) == {("scripts/simulate.py", "")}
    for builder in ("unit_runs", "simulated_response", "homogeneous_response", "response_table"):
        assert definitions(builder) == {("response/unit.py", builder)}


def test_runs_of_the_solver_are_those_of_the_response_and_of_few_others():
    """A loop over fractions elsewhere would be a second builder."""
    runs = {path for path, _ in callers("run")}
    assert {path for path in runs if not path.startswith(("response/", "fem/"))} == {
        "__main__.py",  # a command
        "blindlab/curves.py",  # maker of records
        "calibration/direct.py",
        "figures/offscreen.py",  # a program
        "geometry_effects/prescribed.py",
        "scripts/series.py",
    }


def test_forces_at_displacements_come_from_one_evaluation():
    """Of a response; `method: direct` runs the solver."""
    assert definitions("force_per_mu") == {
        ("response/curves.py", "ResponseCurves.force_per_mu"),
        ("response/elastic.py", "Elastic.force_per_mu"),
    }
    elastic = {place: node for place, node in places(tree_of(PACKAGE / "response/elastic.py"))}
    *_, answer = elastic["Elastic.force_per_mu"].body
    assert ast.unparse(answer) == "return self.curves.force_per_mu(fraction, displacement)"
    change = ast.unparse(elastic["Elastic.change_per_mu"])
    assert "self.perturbations[perturbation].force_per_mu(fraction, displacement)" in change
    of_curves = in_part(definitions("force"), "response/")
    assert of_curves == {
        ("response/curves.py", f"{name}.force") for name in ("ResponseCurves", "Curves", "Scaled")
    } | {
        ("response/perturbations.py", "simulate_perturbations.force"),  # of a run
        ("response/perturbations.py", "_pressed_changes.force"),
    }


def test_curves_are_taken_at_their_points_by_the_response_alone():
    """Whoever else interpolates between them would be a second evaluation."""
    assert {path for path, _ in callers("curve")} <= {
        "response/curves.py", "response/changes.py", "response/elastic.py",
        "response/law_response.py",
    }  # fmt: skip
    interpolating = {path for path, _ in in_part(callers("interp"), "loop/")}
    assert interpolating == {
        "loop/effects/channel_lag.py",
        "loop/effects/platen_slip.py",
    }


def test_one_function_predicts_a_record():
    own = [path for path in FILES if name_of(path).startswith("loop/")]
    assert definitions("predict") == {("loop/model.py", "Model.predict")}
    forces = callers("force_per_mu", own)
    assert {place for place in forces if not place[0].startswith("loop/effects/")} == {
        ("loop/model.py", "Model._elastic"),
        ("loop/model.py", "Model._of_law"),
    }
    assert {path for path, _ in in_part(forces, "loop/effects/")} == {
        "loop/effects/platen_slip.py", "loop/effects/viscoelastic_relaxation.py"
    }  # fmt: skip
    assert callers("elastic", own) == {
        ("loop/model.py", "Model._elastic"),
        ("loop/model.py", "Model._of_law"),
    }
    assert callers("tissue", own) == {("loop/model.py", "Model._force")}
    assert callers("instrument", own) == {("loop/model.py", "Model.reading")}
    assert callers("reading", own) == {
        ("loop/model.py", "Model.predict"),
        ("loop/screen.py", "signatures.predicted"),  # on top of a prediction
    }
    assert callers("travel", own) == {
        ("loop/model.py", "Model._reported"),
        ("loop/correction.py", "_Test.of"),
        ("loop/posed.py", "pose"),
        ("loop/screen.py", "signatures"),
    }
    predicted = tree_of(PACKAGE / "loop/fit.py")
    problem = dict(places(predicted))
    for name, asks in (("predicted", "_predicted"), ("_predicted", "predict")):
        calls = [n for n in ast.walk(problem[f"Problem.{name}"]) if isinstance(n, ast.Call)]
        assert {called(n) for n in calls} - {"len", "range", "zeros"} == {asks}
