"""The page on use from Python: its lines run and print what it says, and its names are there."""

import re
from pathlib import Path

import pytest

import softsample
from softsample.constitutive.homogeneous import homogeneous_force

PAGE = (Path(__file__).resolve().parents[2] / "docs/python.md").read_text(encoding="utf-8")


def test_ten_lines_give_the_curve_that_the_page_shows(capsys):
    code, printed = re.search(r"```python\n((?s:.*?))```\n\n((?:    .*\n)+)", PAGE).groups()
    assert len(code.strip().splitlines()) <= 10
    names = {}
    exec(code, names)
    assert capsys.readouterr().out == re.sub("^    ", "", printed, flags=re.M)
    shape, force = names["shape"], names["force"]
    exact = shape.area * homogeneous_force("compression", 0.2, names["tissue"])
    assert force[-1] == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("name", [*softsample.__all__, *re.findall(r"softsample\.(\w+)\(", PAGE)])
def test_its_names_are_those_of_the_package(name):
    assert getattr(softsample, name) is not None


def test_a_name_that_is_not_there_is_refused_as_of_any_module():
    with pytest.raises(AttributeError, match="no attribute 'simulate'"):
        softsample.simulate  # noqa: B018
