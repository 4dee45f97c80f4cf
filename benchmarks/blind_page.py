"""Writes docs/blindlab.md from the blind laboratory: python benchmarks/blind_page.py."""

from pathlib import Path

from softsample.blindlab.faults import EFFECTS, SCALES, STRANGERS, Kind
from softsample.blindlab.records import DESIGNS, HOLD, MU_PA, REST, SLOW, SPEED, WHITE

PAGE = Path(__file__).parents[1] / "docs/blindlab.md"
HEAD = f"""# The blind laboratory

Written by `benchmarks/blind_page.py` from `softsample.blindlab`; edit the files there.

    make blind        # every effect at its nominal size, design B: results/blind/
    make blind-full   # four sizes, designs A, B and C: results/blind-full/

The laboratory makes records with effects that nobody declares and asks the loop what is wrong. It
shares nothing with the effect library: its formulas are others, relaxation has a continuous
spectrum, its clock is four times as fine, and its elastic curves come from runs on another mesh,
in another loading time and at mixtures off the loop's. Makers of records import nothing of
`softsample.loop`, and the judge nothing of its effects; a test holds that. What is planted is
drawn from seeds, written to `planted.json` and hashed into `seal.json` before the first record is
judged; the answers are frozen in `answers/`; the score opens the seal and refuses if the hash
differs. Seeds from `first_seed` on serve the score alone.

- Samples: cuboids of many proportions; for `real_geometry` phantoms of imperfect shape, whose
  cuboid is the loop's model. Modulus {MU_PA[0]:g} to {MU_PA[1]:g} Pa, drawn anew for every
  experiment.
- Designs at {SPEED:g} mm/s: A the loading ramp alone; B {REST:g} s of rest, ramp, {HOLD:g} s of
  hold, way back; C is B at {" and ".join(f"{speed:g}" for speed in DESIGNS["C"])} times the
  speed.
- Noise {1e3 * WHITE:g} mN white in each sample and {1e3 * SLOW:g} mN with a correlation of a
  second. A floor adds a smooth error of each test that nothing explains, correlated over a
  quarter of the stroke. The loop is told the floor (as a laboratory would know it from
  replicates), and what its own mesh does not resolve: config `blind: noise:`.
- Goals are those of LOOP, by number; `score.json` has value, one-sided 95 % bound and number of
  experiments by design, floor and size. `confusion.csv` and `.png` show which effect an answer
  names first; a class that holds the planted effect counts for it.

## Effects and the size called 1x

Sizes vary by a tenth from experiment to experiment. Rows are those of LOOP's section B.
"""
NEXT = {
    "## What is only another modulus": (SCALES, "The right answer is that nothing can be seen."),
    "## Kinds that the loop has no name for": (
        STRANGERS,
        "The right answer is `unknown` or `none`.",
    ),
}


def page() -> str:
    """The whole page."""
    lines = [HEAD, *_table(EFFECTS)]
    for title, (kinds, words) in NEXT.items():
        lines += ["", title, "", words, "", *_table(kinds)]
    return "\n".join(lines) + "\n"


def _table(kinds: dict[str, Kind]) -> list[str]:
    rows = [f"| `{n}` | {k.row} | {k.nominal} | {k.form} |" for n, k in kinds.items()]
    return ["| name | row of LOOP | 1x | the laboratory's form |", "|---|---|---|---|", *rows]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
