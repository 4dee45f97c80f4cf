"""Scripts of the rules: what they call in the library takes what they give."""

import ast
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).resolve().parents[2] / "workflow/scripts").glob("*.py"))


def value(package, name):
    """What `from package import name` gives: something of it, or a module in it."""
    found = importlib.import_module(package)
    return getattr(found, name, None) or importlib.import_module(f"{package}.{name}")


def imported(tree):
    """Names that a script imports from the library."""
    return {
        alias.asname or alias.name: value(node.module, alias.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module.startswith("softsample")
        for alias in node.names
    }


def misfit(call, function):
    """Why a call cannot be bound to a function's signature; None if it can.

    Arguments behind a star may stand for any that are missing.
    """
    starred = any(isinstance(value, ast.Starred) for value in call.args)
    starred |= any(keyword.arg is None for keyword in call.keywords)
    signature = inspect.signature(function)
    bind = signature.bind_partial if starred else signature.bind
    given = [value for value in call.args if not isinstance(value, ast.Starred)]
    try:
        bind(*given, **{keyword.arg: keyword for keyword in call.keywords if keyword.arg})
    except TypeError as error:
        return f"line {call.lineno}, {ast.unparse(call.func)}: {error}"
    return None


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_calls_of_the_library_fit_its_signatures(script):
    tree = ast.parse(script.read_text(encoding="utf-8"))
    known = imported(tree)
    found = [
        misfit(node, known[node.func.id])
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and inspect.isfunction(known.get(node.func.id))
    ]
    assert [text for text in found if text] == []


def test_a_call_that_does_not_fit_is_found():
    call = ast.parse("f(1, b=2)").body[0].value
    assert misfit(call, lambda a, b: None) is None
    assert "missing a required argument: 'c'" in misfit(call, lambda a, b, c: None)
    assert "unexpected keyword argument 'b'" in misfit(call, lambda a: None)


SELECTION = "softsample.loop.select"


@pytest.mark.parametrize(
    ("name", "knows"), [("simulate", False), ("perturbations", False), ("diagnose", True)]
)
def test_a_change_of_the_selection_simulates_nothing_again(name, knows):
    """A job is out of date when a file changes that its script imports, directly or not."""
    tree = ast.parse((SCRIPTS[0].parent / f"{name}.py").read_text(encoding="utf-8"))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    code = "\n".join(
        [*map(ast.unparse, imports), f"import sys; assert {SELECTION!r} in sys.modules"]
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode == 0) == knows, done.stderr
    assert knows or done.stderr.strip().endswith("AssertionError")
