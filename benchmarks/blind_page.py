"""Writes docs/blindlab.md from the blind laboratory: python benchmarks/blind_page.py."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from softsample.blindlab.faults import EFFECTS, SCALES, STRANGERS, Kind
from softsample.blindlab.records import DESIGNS, HOLD, MU_PA, REST, SLOW, SPEED, WHITE

DOCS = Path(__file__).parents[1] / "docs"
PAGE = DOCS / "blindlab.md"
SCORE = DOCS / "data/blind/score.json"
FULL = DOCS / "data/blind-full/score.json"
HEAD = f"""# The blind laboratory

Written by `benchmarks/blind_page.py` from `softsample.blindlab`; edit the files there.

    make blind        # every effect at nominal size, design B, 1 h on 2 cores: results/blind/
    make blind-full   # four sizes, designs A, B, C, fewer of each: results/blind-full/
    make blind-foreign  # floors of other kinds, sizes not stated: results/blind-*/
    make blind-measured  # the same with residuals of `make measured`: results/blind-measured/

The laboratory makes records with undeclared effects, with its own formulas, clock, mesh, loading
time and modulus fractions (test), and asks the diagnosis for the cause. The ground truth is drawn
from seeds, written to `planted.json` and hashed into `seal.json` before the first record is judged;
scoring refuses any other. Answers are frozen in `answers/`.

- Specimens: cuboids of many proportions; for `real_geometry` phantoms of imperfect shape, modelled
  by their cuboid. Modulus {MU_PA[0]:g} to {MU_PA[1]:g} Pa, drawn for every experiment.
- Designs at {SPEED:g} mm/s: A the loading ramp alone; B {REST:g} s dwell, ramp, {HOLD:g} s
  hold, unloading; C is B at {" and ".join(f"{speed:g}" for speed in DESIGNS["C"])} times the
  speed.
- Noise: {1e3 * WHITE:g} mN white, and {1e3 * SLOW:g} mN with a correlation time of a second.
- Floor: a smooth error of each test that no effect explains, correlated over a quarter of the
  stroke. The diagnosis knows its size and the error of its own mesh (config `blind: noise:`).
- `score.json` has value, one-sided 95 % bound and number of experiments of each goal, by design,
  floor and size. A class (indistinguishable set) that holds the true effect counts as correct.

## Effects and the size called 1x

Sizes vary by a tenth between experiments.
"""
NEXT = {
    "## Effects that only scale the modulus": (
        SCALES,
        "The right answer names no effect.",
    ),
    "## Effects out of the library": (
        STRANGERS,
        "The right answer names no effect: `unknown`, `none` or `explained_class`.",
    ),
}


BARS: dict[str, tuple[str, float, float]] = {
    "1 false alarms": ("<=", 0.05, 0.05),
    "2 effects with power": (">=", 23, 18),
    "3 class correct when noticed": (">=", 0.95, 0.92),
    "4 exact effect first": (">=", 0.85, 0.75),
    "5 confidently wrong": ("<=", 0.03, 0.05),
    "6 out of library: unknown or none": (">=", 0.85, 0.60),
    "7 called unknown": ("<=", 0.08, 0.12),
    "8 pairs: both classes": (">=", 0.85, 0.75),
    "8 pairs: at least one": (">=", 0.97, 0.95),
    "8 pairs: wrong extra": ("<=", 0.06, 0.10),
    "9 held-out error removed": (">=", 0.80, 0.60),
    "10 held-out worse by 5 %": ("<=", 0.02, 0.04),
    "11 white RMS after": ("<=", 1.1, 1.3),
    "12 bias of mu removed": (">=", 0.80, 0.60),
    "13 cover of mu": (">=", 0.85, 0.80),
    "13 cover of recommended mu": (">=", 0.85, 0.85),
    "13 cover of effects": (">=", 0.85, 0.80),
    "14 error of the size": ("<=", 0.10, 0.20),
    "16 stated confidence less hits": ("<=", 0.05, 0.08),
}
"""Criterion of each goal, without floor and with one of 1 %."""
COUNTS = ("2 effects with power", "11 white RMS after")
"""Goals that are no shares."""

SCORED = """
## Score

Written from [data/blind/score.json](data/blind/score.json): design B, nominal sizes; {judged} of
{planned} experiments judged. Unlike that of the [undeclared groups](loop.md#results), this score
was not frozen before the truth was known: earlier rules were scored on these seeds, and half of the
null experiments with discrepancy served to select the covariance kernels.

**The 90 % intervals of effects hold the true size in {covered} % of the cases, with a floor in
{covered_floor} %.** In brackets the one-sided 95 % bound; bold: criterion not met. An effect has
power if it is noticed in 95 % of its experiments (counts are out of 25). The recommended modulus is
scored in all experiments with one effect. The median verdict takes {cpu} CPU s.

| goal | criterion | noise only | criterion | floor 1 % |
|---|---|---|---|---|"""

WITHIN_REACH = """
Attainable: an answer that left only the error of records without effects would remove {} %
of the held-out error without a floor, {} % with it. Of pairs whose effects both have power,
both classes are named in {} % without a floor ({} pairs), in {} % with it ({} pairs)."""

PER_EFFECT = """
Effects that were not always noticed, or wrongly named (all others: 100 % and 0 %):

| effect | noticed [%] | wrong | noticed, floor 1 % | wrong |
|---|---|---|---|---|"""

FULL_SCORE = """
## All sizes and designs

Written from [data/blind-full/score.json](data/blind-full/score.json): {judged} of {planned}
experiments, {seeds} of each effect, design, size and floor, of 22 November 2026; the diagnosis has
changed since. Percentages at {sizes} times the nominal size: effects noticed, those of them in the
right class, and effects wrongly named. Then false alarms, effects out of the library called
unknown or none, and pairs at 1x with both classes named.

| design | floor [%] | noticed [%] | class right | wrong | false alarms | out of library | pairs |
|---|---|---|---|---|---|---|---|"""

CONFUSION = """
![Ground truth against answers](figures/blind/confusion.png)
"""

Rows = Mapping[tuple[Any, ...], Mapping[str, Any]]


def page() -> str:
    """The whole page."""
    lines = [HEAD, *_table(EFFECTS)]
    for title, (kinds, words) in NEXT.items():
        lines += ["", title, "", words, "", *_table(kinds)]
    for path, section in ((SCORE, _score), (FULL, _full)):
        if path.exists():
            found = json.loads(path.read_text(encoding="utf-8"))
            lines += section(found)
    return "\n".join(lines) + "\n"


def _score(found: Mapping[str, Any]) -> Iterator[str]:
    """Goals beside their bars, then every effect."""
    rows: Rows = {(row["goal"], row["floor_percent"]): row for row in found["score"]}
    costs = [f"{rows['17 CPU seconds a verdict', floor]['value']:.2g}" for floor in (0.0, 1.0)]
    covered = [_shown("", rows["13 cover of effects", floor]["value"]) for floor in (0.0, 1.0)]
    yield SCORED.format(
        **found["experiments"],
        cpu=" and ".join(costs),
        covered=covered[0],
        covered_floor=covered[1],
    )
    for goal, (sign, *bars) in BARS.items():
        cells = [
            f"{sign} {_shown(goal, bar)} | {_judged(goal, sign, bar, rows[goal, floor])}"
            for floor, bar in zip((0.0, 1.0), bars, strict=True)
        ]
        unit = "" if goal in COUNTS else " [%]"
        yield f"| {goal.lstrip('0123456789 ')}{unit} | {' | '.join(cells)} |"
    left, able = (
        [rows.get((goal, floor), {"value": None, "n": 0}) for floor in (0.0, 1.0)]
        for goal in (
            "9 if undisturbed records' error were left",
            "8 pairs of effects with power: both classes",
        )
    )
    yield WITHIN_REACH.format(
        *(_shown("", row["value"]) for row in left),
        *(cell for row in able for cell in (_shown("", row["value"]), row["n"])),
    )
    yield PER_EFFECT
    for name in EFFECTS:
        cells = [
            _shown(goal, rows[f"{goal} {name}", floor]["value"])
            for floor in (0.0, 1.0)
            for goal in ("2 power", "5 wrong")
        ]
        if cells != ["100", "0"] * 2:
            yield f"| `{name}` | {' | '.join(cells)} |"
    yield CONFUSION.rstrip()


def _full(found: Mapping[str, Any]) -> Iterator[str]:
    """Every design, floor and size."""
    rows = {
        (row["goal"], row["design"], row["floor_percent"], row["size"]): row
        for row in found["score"]
    }
    settings = sorted({(design, floor) for _, design, floor, _ in rows})
    sizes = sorted({size for *_, size in rows if size is not None})
    power = {
        (name, *setting, size): rows[f"2 power {name}", *setting, size]
        for name in EFFECTS
        for setting in settings
        for size in sizes
        if (f"2 power {name}", *setting, size) in rows
    }
    yield FULL_SCORE.format(
        **found["experiments"],
        seeds=max(row["n"] for row in power.values()),
        sizes=", ".join(f"{size:g}" for size in sizes),
    )
    for setting in settings:
        noticed = []
        for size in sizes:
            here = [row for (_, *where), row in power.items() if where == [*setting, size]]
            noticed.append(
                sum(row["value"] * row["n"] for row in here) / sum(row["n"] for row in here)
            )
        goals = ("3 class correct when noticed", "5 confidently wrong")
        named = [[rows[goal, *setting, size]["value"] for size in sizes] for goal in goals]
        cells = [", ".join(_shown("", x) for x in row) for row in (noticed, *named)]
        whole = ("1 false alarms", "6 out of library: unknown or none", "8 pairs: both classes")
        cells += [_shown("", rows[goal, *setting, None]["value"]) for goal in whole]
        yield f"| {setting[0]} | {setting[1]:g} | {' | '.join(cells)} |"


def _judged(goal: str, sign: str, bar: float, row: Mapping[str, Any]) -> str:
    """Value with its bound, bold where it misses the bar."""
    if row["value"] is None:
        return "–"
    met = row["value"] <= bar if sign == "<=" else row["value"] >= bar
    value = _shown(goal, row["value"])
    bound = "" if row["bound"] is None else f" ({_shown(goal, row['bound'])})"
    return f"{value if met else f'**{value}**'}{bound}"


def _shown(goal: str, value: float | None) -> str:
    """Shares in percent."""
    if value is None:
        return "–"
    return f"{value:.3g}" if goal in COUNTS else f"{100.0 * value:.0f}"


def _table(kinds: dict[str, Kind]) -> list[str]:
    rows = [f"| `{n}` | {k.nominal} | {k.form} |" for n, k in kinds.items()]
    return ["| name | 1x | form in the laboratory |", "|---|---|---|", *rows]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
