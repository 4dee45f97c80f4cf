"""Samples of a study against each other: what fits its own file, but none of the others."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from softsample.arrays import Array
from softsample.imaging.propose import Glance
from softsample.meshing.surface import TriangleSurface
from softsample.plausibility import Limits, figures
from softsample.protocol import ALIKE
from softsample.records import Record
from softsample.shapes import IdealShape
from softsample.units import MM

FEWEST = 2
"""Samples of other groups that one is compared with."""

UNLIKE = {
    "volume_mm3": (
        "a sample of about {:.3g} mm3, {} the others' volume; is it the right file, and are voxels "
        "and dimensions in mm?",
        1.0,
    ),
    "stiffness_pa": (
        "stress over strain of {:.3g} kPa, {} the others' in this mode; is it the right record, "
        "with the right units?",
        1e-3,
    ),
}
"""What is said of a figure that is far from the others', and its factor there."""


@dataclass(frozen=True)
class Seen:
    """A row of the study table with what was seen in its files.

    Parameters
    ----------
    where : str
        Table, row and sample, for messages.
    row : dict
        Its sound cells.
    facts : dict or None
        Of its record, with `doubted`: whether it is doubted by itself, and `held_out_by`: numbers
        of the selections of `hold_out` that select some of it.
    size : IdealShape or None
        About as large as the sample.
    found : list of str
        What its files hold and how they are understood.
    record : Record or None
        With phases and what is calibrated.
    image : (array, array) or None
        Its image at low resolution, and the affine from voxel to world [mm].
    glance : Glance or None
        What was segmented in that image.
    surface : TriangleSurface or None
        The closed surface that is given in place of an image [m].
    """

    where: str
    row: Mapping[str, str]
    facts: Mapping[str, Any] | None
    size: IdealShape | None
    found: Sequence[str] = ()
    record: Record | None = None
    image: tuple[Array, Array] | None = None
    glance: Glance | None = None
    surface: TriangleSurface | None = None

    @property
    def figures(self) -> dict[str, float]:
        """`volume_mm3`, and those of `softsample.plausibility`; none if doubted already."""
        if self.size is None or (self.facts and self.facts["doubted"]):
            return {}
        of_record = figures(self.facts, self.size) if self.facts else {}
        return of_record | {"volume_mm3": self.size.volume / MM**3}


def compared(seen: Sequence[Seen], limits: Limits) -> Iterator[str]:
    """What tells a sample from all others of its group, or of the study if it is alone there."""
    yield from _same_file(seen)
    yield from _several_speeds(seen)
    for one in seen:
        others = [other for other in seen if other is not one]
        yield from _unlike(one, others, "volume_mm3", limits.volume_ratio)
        alike = [other for other in others if other.row.get("mode") == one.row.get("mode")]
        yield from _unlike(one, alike, "stiffness_pa", limits.stiffness_ratio)
        yield from _cut_off(one, alike, limits.strain_ratio)


def _ratios(one: Seen, others: Sequence[Seen], name: str) -> tuple[float, list[float]]:
    """A figure of a sample, and how many times that of each other one it is."""
    own = one.figures.get(name, 0.0)
    close = [other for other in others if other.row.get("group") == one.row.get("group")]
    if not close and len(others) < FEWEST:
        return own, []
    values = [other.figures.get(name, 0.0) for other in close or others]
    return own, [own / other for other in values if other and own]


def _unlike(one: Seen, others: Sequence[Seen], name: str, limit: float) -> Iterator[str]:
    """Whether a figure is far from all others', on the same side."""
    told, scale = UNLIKE[name]
    own, ratios = _ratios(one, others, name)
    if ratios and (min(ratios) > limit or max(ratios) < 1.0 / limit):
        setting = f"{name.partition('_')[0]}_ratio: {_accepted(ratios):g}"
        yield (
            f"{one.where}: {told.format(scale * own, _times(ratios))} If it is right, set "
            f"`plausibility: {{{setting}}}`"
        )


def _cut_off(one: Seen, others: Sequence[Seen], limit: float) -> Iterator[str]:
    own, ratios = _ratios(one, others, "strain")
    in_ramp = one.facts is not None and one.facts["phases"][-1]["kind"] == "ramp"
    if ratios and max(ratios) < 1.0 / limit and in_ramp:
        yield (
            f"{one.where}: the record ends in its ramp, at a strain of {100.0 * own:.3g} %, "
            f"{_times(ratios)} the others' in this mode; was it cut off? Export the whole test. If "
            f"it is whole, set `plausibility: {{strain_ratio: {_accepted(ratios):g}}}`"
        )


def _times(ratios: Sequence[float]) -> str:
    low, high = (f"{end:.2g}" for end in (min(ratios), max(ratios)))
    return f"{low} times" if low == high else f"{low} to {high} times"


def _accepted(ratios: Sequence[float]) -> float:
    """A limit with which the nearest of the others is near enough."""
    nearest = min(max(ratio, 1.0 / ratio) for ratio in ratios)
    return float(f"{1.25 * nearest:.2g}")


def _same_file(seen: Sequence[Seen]) -> Iterator[str]:
    """Files that stand in several rows, and should not."""
    for column in ("record", "image", "surface"):
        first: dict[tuple[str, str | None], Seen] = {}
        for one in seen:
            name = one.row.get(column, "")
            sheet = one.facts["reading"].get("sheet") if one.facts and column == "record" else None
            other = first.setdefault((name, sheet), one) if name else one
            if other is one or (column != "record" and _piece(one) == _piece(other)):
                continue
            cure = (
                "give each test its own file"
                if column == "record"
                else f"if it is the same piece, write {_piece(other)} into column specimen"
            )
            yield (
                f"{one.where}, column {column!r}: {name} stands in the row of "
                f"{other.row.get('sample', '?')} already; {cure}"
            )


def _several_speeds(seen: Sequence[Seen]) -> Iterator[str]:
    """Tests at several speeds of what may be one piece, and is not said to be."""
    tests: dict[Any, list[Seen]] = {}
    for one in seen:
        if one.row.get("shape") and one.size is not None and one.facts and _piece_is_open(one):
            key = one.row.get("group"), one.row.get("mode"), one.size
            tests.setdefault(key, []).append(one)
    for first, *others in tests.values():
        speeds = [one.facts["ramp_speed_mm_s"] or 0.0 for one in (first, *others) if one.facts]
        for one in others if max(speeds) > ALIKE * min(speeds) > 0.0 else ():
            name = first.row.get("sample", "?")
            yield (
                f"{one.where}, column 'specimen': the dimensions are those of {name}, and speeds "
                f"differ; if it is the same piece, write {name} into column specimen: what goes "
                "with the speed then shows far better"
            )


def _piece_is_open(one: Seen) -> bool:
    return one.row.get("specimen", "") in ("", one.row.get("sample"))


def _piece(one: Seen) -> str:
    return one.row.get("specimen", one.row.get("sample", "?"))
