"""Pages and messages use the field's terms: none of the project's former words is left."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FORMER = {
    "way back": "unloading",
    "glue": "bond, adhesive",
    "glued": "bonded",
    "gluing": "bonding",
    "contact zeros?": "contact-point offset",
    "taken off": "corrected for, subtracted",
    "carried on": "extrapolated",
    "made anew": "recomputed",
    "passed over": "ignored",
    "lets? go": "release",
    "pilots?": "preliminary runs",
    "planted": "ground truth",
    "strangers?": "out of the library",
    "sealed": "withheld ground truth",
    "unserved": "evidence that no candidate explains",
    "spoil(?:s|ed)": "degraded fit",
    "taken back": "eliminated",
    "white mean squares?": "reduced chi-square",
    "doubt of (?:the )?form": "model-form uncertainty",
    "mixtures?": "modulus fraction",
    "made-up": "synthetic",
    "records of others": "third-party data",
    "what the model lacks": "residual diagnosis",
    "curve famil(?:y|ies)|famil(?:y|ies) of curves": "precomputed response curves",
    "to the bit": "bitwise reproducible",
    "without a word": "unexpectedly",
    "marks? of thousands": "thousands separators",
    "world of the image": "image coordinate system",
    "travels?": "platen displacement",
    "grain": "discretisation noise",
    "form doubt": "model-form uncertainty",
    "doubting": "model-form uncertainty",
    "neutral values?": "null value",
    "nominal values?": "reference value",
    "confused with": "confounded with",
    "what would tell": "discriminating experiment",
    "nothing is given": "no effect is reported",
    "benches": "test rigs",
    "in sight": "fitted data",
    "pace": "loading time",
    "march(?:es)?": "time integration",
    "bars? holds?": "criterion met",
}
"""Former word, and what is written in its place (docs/glossary.md)."""

WORDS = re.compile(rf"(?<![\w-])({'|'.join(FORMER)})(?![\w-])", re.IGNORECASE)
CODE = re.compile(r"```.*?```|`[^`]*`|\]\([^)]*\)|{{.*?}}|{%.*?%}", re.DOTALL)
PAGES = sorted(
    path
    for pattern in (
        "*.md", "docs/*.md", "config/*.md", "workflow/report/*", "workflow/schemas/*.yaml",
        "benchmarks/*.j2",
    )
    for path in ROOT.glob(pattern)
    if path.is_file() and path.name != "CHANGELOG.md"
)  # fmt: skip
MODULES = sorted([*(ROOT / "src").rglob("*.py"), *(ROOT / "benchmarks").glob("*.py")])


def former(text):
    """Former words of a text, without what is code."""
    return [match.group() for match in WORDS.finditer(CODE.sub("", text))]


LABELLED = {"set_xlabel", "set_ylabel", "set_title", "suptitle", "supxlabel", "supylabel", "text",
            "annotate"}  # fmt: skip
LABELS = {"label", "title", "xlabel", "ylabel"}


def labels(call):
    """What a call writes into a figure, single words too."""
    name = getattr(call.func, "attr", None)
    yield from call.args if name in LABELLED else ()
    yield from (keyword.value for keyword in call.keywords if keyword.arg in LABELS)


def messages(source):
    """Strings of a module that people read: those with spaces, and all that label a figure.

    Docstrings are left out.
    """
    tree = ast.parse(source)
    said = {
        id(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }
    written = {
        id(text) for node in ast.walk(tree) if isinstance(node, ast.Call) for text in labels(node)
    }
    for node in ast.walk(tree):
        if id(node) in said or not isinstance(node, ast.Constant):
            continue
        if isinstance(node.value, str) and (" " in node.value.strip() or id(node) in written):
            yield node.value


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_page_has_none(path):
    assert former(path.read_text(encoding="utf-8")) == []


def test_no_message_has_any():
    found = {
        str(path.relative_to(ROOT)): words
        for path in MODULES
        if (words := [w for text in messages(path.read_text("utf-8")) for w in former(text)])
    }
    assert found == {}


def test_a_single_word_in_a_figure_is_read_and_a_key_is_not():
    source = 'ax.set_ylabel("planted")\nax.plot(x, label="glued")\nrow["planted"] = "sealed"\n'
    assert [*messages(source)] == ["planted", "glued"]
    assert [word for text in messages(source) for word in former(text)] == ["planted", "glued"]


def test_former_words_are_found_and_code_is_not():
    assert former("The glue is on the `glued` nodes; Contact zero") == ["glue", "Contact zero"]
    assert former("unglued, glue-like, [meshing](glue.md)") == []
