"""Writes docs/effects.md from the library of effects: python benchmarks/effects_page.py."""

from pathlib import Path

from softsample.loop.effects import library
from softsample.loop.effects.base import Effect, Parameter

PAGE = Path(__file__).parents[1] / "docs/effects.md"
TIERS = {
    "P": "post-processing of the predicted record",
    "L": "a run of the solver for each parameter",
    "M": "runs of a changed model",
}
HEAD = """# Effects that the diagnosis can name

Written by `benchmarks/effects_page.py` from `src/softsample/loop/effects`; edit the files there.
How they are chosen, and how to add one, is in [loop.md](loop.md). Offsets, drift and weight have
the signs of the machine (positive in tension and along +x), displacement is positive while loading.

An effect is absent at the null values of its amplitudes. Its sensitivity is computed at the
reference values. *Shapes* (times, onsets) enter nonlinearly and are fitted from each initial guess.
Ranges of lengths and forces hold for samples 6.5 to 26 mm high and peak forces of 0.2 to 5 N;
beyond these they are scaled with height and peak force (`softsample.loop.candidates`).
Pure shear counts as tension, confined compression as compression.
Records without time have no effects of time among their candidates. Times of relaxation are those
of a usual study here; they follow the clock of the records. `specimen_stiffness` has one size,
named after the specimen, for every specimen but the first of its mode.
"""


def page() -> str:
    """The whole page."""
    known = library().values()
    lines = [HEAD, "| effect | tests | cost | of time | identifiable |", "|---|---|---|---|---|"]
    lines += [
        f"| [`{e.name}`](#{e.name}): {e.title} | {', '.join(e.modes)} | {e.tier} "
        f"| {'yes' if e.of_time else 'no'} | {'yes' if e.identifiable else 'no'} |"
        for e in known
    ]
    costs = ", ".join(f"{tier}: {text}" for tier, text in TIERS.items())
    lines += ["", f"Cost: {costs}.", ""]
    return "\n".join(lines + [line for effect in known for line in _section(effect)])


def _section(effect: Effect) -> list[str]:
    confused = ", ".join(f"[`{name}`](#{name})" for name in effect.confused_with)
    identifiable = "" if effect.identifiable else " No test at one speed can show it."
    return [
        f"## `{effect.name}`",
        "",
        f"{effect.title}. Signature: {effect.signature}.{identifiable}",
        "",
        "| parameter | unit | range | null value | reference value | initial guesses |",
        "|---|---|---|---|---|---|",
        *(_row(p) for p in effect.parameters),
        "",
        f"- Confounded with: {confused}.",
        f"- Discriminating experiment: {effect.experiment}.",
        f"- Source of form and range: {effect.source}.",
        "",
    ]


def _row(p: Parameter) -> str:
    neutral = f"{p.neutral:g}" if p.is_size else "shape"
    starts = ", ".join(f"{value:g}" for value in p.grid) or "-"
    cells = [f"`{p.name}`", p.unit, f"{p.low:g} to {p.high:g}", neutral, f"{p.nominal:g}", starts]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
