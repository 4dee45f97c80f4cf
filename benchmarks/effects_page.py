"""Writes docs/effects.md from the library of effects: python benchmarks/effects_page.py."""

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

from softsample.loop.effects import library
from softsample.loop.effects.base import Effect, Parameter

PAGE = Path(__file__).parents[1] / "docs/effects.md"
ALL = {"tension", "compression", "shear"}
HEAD = """# Effects that the diagnosis can name

Written by `benchmarks/effects_page.py` from `src/softsample/loop/effects`; edit the files there.
Selection: [loop.md](loop.md); how to add one: [CONTRIBUTING.md](../CONTRIBUTING.md).

An effect is absent at the null values of its amplitudes (0 unless stated). Signatures are
computed at the reference values. Parameters marked *shape* (times, onsets) enter nonlinearly and
are fitted from several initial guesses. Offsets, drift and weight have the signs of the machine
(positive in tension and along +x); displacement is positive while loading.

Ranges of lengths and forces hold for samples 6.5 to 26 mm high and peak forces of 0.2 to 5 N;
beyond, they scale with height and peak force. `self_weight` of a sample of known shape is at most
the weight of its volume at 1.2 g/cm3. The three relaxation times have equal ratios and
follow loading time and duration of the records; the table has those of a usual study.
`specimen_stiffness` has one parameter, named after the specimen, for every specimen but the first
of its mode and direction. Where the study table states how each piece was cut (`material_z`,
`material_x`), the fibres of `anisotropy` have one direction in the material (`azimuth_deg` from
direction 1 towards 2, `elevation_deg` towards 3) and a `k1` of up to 5. Pure shear counts as
tension, confined compression and indentation as compression, torsion as shear. Effects marked
*time* need records with time.
"""


def page() -> str:
    """The whole page."""
    known = library().values()
    lines = [
        HEAD,
        "| effect | tests | parameter | range | reference value |",
        "|---|---|---|---|---|",
        *(row for effect in known for row in _rows(effect)),
    ]
    lines.append("")
    return "\n".join(lines + [line for effect in known for line in _section(effect)])


def _section(effect: Effect) -> list[str]:
    confused = ", ".join(f"[`{name}`](#{name})" for name in effect.confused_with)
    hidden = effect.sizes and not effect.identifiable
    identifiable = " No test at one speed shows it." if hidden else ""
    return [
        f"## `{effect.name}`",
        "",
        f"{effect.title}. {effect.signature[0].upper()}{effect.signature[1:]}.{identifiable}",
        "",
        f"Confounded with {confused}. Experiment: {effect.experiment}.",
        "",
        f"Source: {effect.source}.",
        "",
    ]


def _rows(effect: Effect) -> Iterator[str]:
    """Its lines of the table, one for each parameter, or for those of one range."""
    tests = "all" if set(effect.modes) == ALL else ", ".join(effect.modes)
    about = [f"[`{effect.name}`](#{effect.name})", f"{tests}, time" if effect.of_time else tests]
    if not effect.parameters:
        yield f"| {' | '.join([*about, '–', '–', '–'])} |"
    for range_of, alike in groupby(effect.parameters, _range):
        names = ", ".join(f"`{p.name}`" for p in alike)
        yield f"| {' | '.join([*about, names, *range_of])} |"
        about = ["", ""]


def _range(p: Parameter) -> tuple[str, str]:
    """Range of a parameter, with what is known of it, and its reference value."""
    unit = "" if p.unit == "1" else f" {p.unit}"
    null = f", null {p.neutral:g}" if p.neutral else ""
    kind = null if p.is_size else ", shape"
    if p.known:
        kind += f"; known: {p.known[0]:g} ± {p.known[1]:g}"
    return f"{p.low:g} to {p.high:g}{unit}{kind}", f"{p.nominal:g}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
