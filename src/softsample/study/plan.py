"""What a study computes for the rows of its table: geometries, equal pieces, models."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from softsample.errors import InputError
from softsample.holdout import Row, folds, in_turn, wholly_held_out
from softsample.protocol import GEOMETRIES, ONE_TERM, PRESSED_MODES, TWO_TERM, is_homogeneous
from softsample.shapes import BONDED
from softsample.validation import DEFAULT_AXES, ends_of, has_open_ends, modelled_ends, resolved

MODES = (
    "shear", "tension", "compression", "pure_shear", "confined_compression", "indentation",
    "torsion",
)  # fmt: skip
"""Loading modes in the order in which figures and tables show them."""

PIECE = (
    "group", "image", "surface", "shape", "length_mm", "width_mm", "height_mm", "diameter_mm",
    "segmentation", "bond_mask", "labels", "loading_axis", "shear_axis", "mode", "ends",
    "indenter", "indenter_radius_mm",
)  # fmt: skip
"""Cells of a row that its mesh and its response depend on."""


@dataclass(frozen=True)
class Plan:
    """Geometries, pieces and models of a study.

    A piece stands for all samples of one group with the same geometry, mode and ends: they
    share mesh, curves and everything that is computed from these. It has the name of the first.

    Parameters
    ----------
    rows : mapping
        Rows of the table of samples by sample, empty cells left out.
    hold_out : sequence of mapping, leave_out : str, optional
        Settings of these names, checked (`softsample.holdout.check_hold_out`).

    Raises
    ------
    InputError
        If a name is a sample of one group and the name of another one that has other geometries;
        by methods, if there is no sample or group of a name.
    """

    rows: Mapping[str, Row]
    hold_out: Sequence[Mapping[str, Any]] = ()
    leave_out: str | None = None

    def __post_init__(self) -> None:
        for sample, row in self.rows.items():
            other = self._geometries.get(sample)
            if other and other != self._geometries[row["group"]]:
                raise InputError(
                    f"{sample!r} is a sample of group {row['group']!r} and the name of a group "
                    "whose geometries differ; rename one of them"
                )

    @cached_property
    def groups(self) -> dict[str, list[str]]:
        """Samples by group, both in the order of the table."""
        groups: dict[str, list[str]] = {}
        for sample, row in self.rows.items():
            groups.setdefault(row["group"], []).append(sample)
        return groups

    @cached_property
    def held_out(self) -> set[str]:
        """Samples that are held out as a whole: a model of theirs alone cannot be calibrated."""
        return {name for name, row in self.rows.items() if wholly_held_out(row, self.hold_out)}

    def row(self, sample: str) -> Row:
        """The sample's row."""
        return self.rows[_known(sample, self.rows, "sample")]

    def samples_of(self, group: str) -> list[str]:
        """The group's samples."""
        return self.groups[_known(group, self.groups, "group")]

    def cells_of(self, samples: Sequence[str]) -> list[dict[str, str]]:
        """Rows of samples, with what empty cells mean."""
        return [resolved(self.rows[name]) for name in samples]

    def has_image(self, sample: str) -> bool:
        """Whether the sample comes with an image."""
        return "image" in self.row(sample)

    def has_real(self, sample: str) -> bool:
        """Whether the sample's true shape is known, by an image or a surface."""
        return self.has_image(sample) or "surface" in self.row(sample)

    @cached_property
    def _geometries(self) -> dict[str, list[str]]:
        """Geometries by group."""
        return {
            group: [*GEOMETRIES] if all(map(self.has_real, samples)) else ["ideal"]
            for group, samples in self.groups.items()
        }

    def geometries(self, name: str) -> list[str]:
        """Geometries that a group, or the group of a sample, is calibrated on.

        A group has the real one if all its samples have an image or a surface.
        """
        return self._geometries[name if name in self.groups else self.row(name)["group"]]

    def best(self, name: str) -> str:
        """The geometry nearest to the sample: `real` if there is one, else `ideal`."""
        return self.geometries(name)[0]

    @cached_property
    def _piece(self) -> dict[tuple[str, ...], list[str]]:
        """Samples by what their mesh and response depend on."""
        found: dict[tuple[str, ...], list[str]] = {}
        for sample, row in self.rows.items():
            key = tuple({**DEFAULT_AXES, **resolved(row)}.get(cell, "") for cell in PIECE)
            found.setdefault(key, []).append(sample)
        return found

    @cached_property
    def piece_of(self) -> dict[str, str]:
        """The piece of every sample: the first sample with the same geometry, mode and ends."""
        owners = {sample: same[0] for same in self._piece.values() for sample in same}
        return {sample: owners[sample] for sample in self.rows}

    @cached_property
    def pieces(self) -> list[str]:
        """All pieces, in the order of the table."""
        return list(dict.fromkeys(self.piece_of.values()))

    def same_piece(self, sample: str) -> list[str]:
        """Samples that share the sample's piece."""
        own = self.piece_of[_known(sample, self.rows, "sample")]
        return [name for name, piece in self.piece_of.items() if piece == own]

    def pieces_of(self, group: str) -> list[str]:
        """Pieces of a group."""
        return list(dict.fromkeys(self.piece_of[name] for name in self.samples_of(group)))

    def members(self, group: str, model: str) -> list[str]:
        """Samples of a group that a model is calibrated on.

        The one-term model is calibrated on compression alone, as in Table 2 of the paper.
        """
        samples = self.samples_of(group)
        if model == ONE_TERM:
            return [name for name in samples if self.rows[name]["mode"] == "compression"]
        return samples

    def models(self, group: str) -> list[str]:
        """Material models that a group can be calibrated with."""
        return [
            model
            for model in (TWO_TERM, ONE_TERM)
            if set(self.members(group, model)) - self.held_out
        ]

    def sample_models(self, sample: str) -> list[str]:
        """Material models that a sample takes part in."""
        group = self.row(sample)["group"]
        return [model for model in self.models(group) if sample in self.members(group, model)]

    @cached_property
    def runs(self) -> list[tuple[str, str]]:
        """Piece and geometry of everything that is simulated."""
        return [(piece, geometry) for piece in self.pieces for geometry in self.geometries(piece)]

    @cached_property
    def curves(self) -> list[tuple[str, str, str]]:
        """Piece, geometry and model of all response curves."""
        return [(*run, model) for run in self.runs for model in self.sample_models(run[0])]

    @cached_property
    def imaged(self) -> list[str]:
        """Pieces with an image."""
        return [piece for piece in self.pieces if self.has_image(piece)]

    @cached_property
    def compressed(self) -> list[str]:
        """Pieces that are tested in compression."""
        return [piece for piece in self.pieces if self.rows[piece]["mode"] == "compression"]

    @cached_property
    def banded(self) -> list[str]:
        """Pieces whose boundary is known to a standard deviation: from an image, not a surface."""
        return [piece for piece in self.imaged if "real" in self.geometries(piece)]

    @cached_property
    def bonded(self) -> list[str]:
        """Pieces of real geometry whose top is bonded by a rule: not pressed, and no mask."""
        return [
            piece
            for piece in self.pieces
            if "real" in self.geometries(piece)
            and self.rows[piece]["mode"] not in PRESSED_MODES
            and "bond_mask" not in self.rows[piece]
        ]

    def bonded_of(self, group: str) -> list[str]:
        """Samples of a group whose piece is bonded by a rule."""
        return [name for name in self.samples_of(group) if self.piece_of[name] in self.bonded]

    def has_closed_form(self, sample: str, geometry: str, ends: str | None = None) -> bool:
        """Whether the sample deforms uniformly, so that its response needs no run."""
        row = self.row(sample)
        return geometry == "ideal" and is_homogeneous(row["mode"], ends or modelled_ends(row))

    def coarsening(self, times: float, sample: str, geometry: str) -> float:
        """Size of elements over that of the settings, asked for as `times`.

        Any mesh holds a uniform field, but for one that is too coarse for a thin cylinder.
        """
        return 2 if self.has_closed_form(sample, geometry) else times

    def simulated(self, group: str) -> list[str]:
        """Pieces of a group whose response to a law is simulated."""
        best = self.best(group)
        return [name for name in self.pieces_of(group) if not self.has_closed_form(name, best)]

    def _alike(self, group: str) -> list[str]:
        """Groups whose geometry is known as well as that of the group: others have another bias."""
        best = self.best(_known(group, self.groups, "group"))
        return [name for name in self.groups if self.best(name) == best]

    def in_turn(self, geometry: str) -> dict[str, list[str]]:
        """Samples of groups that tell of each other, by group: those of one best geometry.

        None if what the study holds out is not held out of one group at a time.
        """
        alike = {name: names for name, names in self.groups.items() if self.best(name) == geometry}
        return alike if in_turn(self.hold_out, self.leave_out, alike) else {}

    def is_told(self, group: str) -> bool:
        """Whether other groups tell of one."""
        return group in self.in_turn(self.best(_known(group, self.groups, "group")))

    def pool(self, geometry: str) -> list[str]:
        """Samples of the groups that tell of each other."""
        groups = self.in_turn(geometry)
        return [name for name, row in self.rows.items() if row["group"] in groups]

    def open_others(self, group: str) -> list[str]:
        """Other groups of open ends, which tell what the platens do to those of the group."""
        return [name for name in self._open_groups if group in self._open_groups and name != group]

    @cached_property
    def _open_groups(self) -> list[str]:
        return [name for name, samples in self.groups.items() if self._open.intersection(samples)]

    @cached_property
    def _open(self) -> set[str]:
        return {name for name, row in self.rows.items() if has_open_ends(row)}

    @cached_property
    def pooled(self) -> list[str]:
        """Groups whose verdict takes files of others."""
        return [
            name
            for name in self.groups
            if self.open_others(name) or (self.leave_out == "group" and self._alike(name) != [name])
        ]

    def folds(self, group: str) -> dict[str, list[str]]:
        """Samples of each part of a group that is left out in turn, by the name of the fold.

        None where the study holds something out of one group at a time.
        """
        if self.leave_out == "group":
            return {} if self.is_told(group) else {f"leave_out_{group}": self.samples_of(group)}
        rows = [self.rows[name] for name in self.samples_of(group)]
        return {f"leave_out_{value}": names for value, names in folds(rows, self.leave_out)}

    def diagnosed(self, group: str) -> list[str]:
        """Samples that a diagnosis is told of: of the group, or of all alike if one is left out."""
        if self.leave_out != "group" or self.is_told(group):
            return self.samples_of(group)
        alike = self._alike(group)
        return [name for name, row in self.rows.items() if row["group"] in alike]

    def opened(self, samples: Sequence[str]) -> Sequence[str]:
        """The same samples if the ends of one of them are open, else none."""
        return samples if self._open.intersection(samples) else []

    def bonded_by_rule(self, samples: Sequence[str]) -> list[bool]:
        """Whether each of some samples has its real top bonded by a rule."""
        return [self.piece_of[name] in self.bonded for name in samples]

    def only_bonded(self, samples: Sequence[str]) -> list[str]:
        """Those of some samples that have."""
        return [name for name in samples if self.piece_of[name] in self.bonded]

    def real_of(self, sample: str) -> list[str]:
        """The sample, if its group has the real geometry."""
        return [sample] if "real" in self.geometries(sample) else []

    def check_alike(self) -> None:
        """Refuse what experiments on shape and exponents of whole cohorts are not made for.

        Raises
        ------
        InputError
            If a shape is not known, ends are not bonded, a piece has several tests, or parts of
            records are held out.
        """
        if self.hold_out:
            raise InputError(
                "experiments on shape and free exponents use whole records; ask for them without "
                "the setting hold_out"
            )
        for name, row in self.rows.items():
            wrong = {
                "has neither image nor surface": not self.has_real(name),
                "has ends that are not bonded": ends_of(row) != BONDED,
                f"has the piece of {self.piece_of[name]!r}": self.piece_of[name] != name,
            }
            for what, is_so in wrong.items():
                if is_so:
                    raise InputError(
                        f"sample {name!r} {what}: experiments on shape and free exponents need "
                        "samples of known shape with bonded ends, each tested once; ask for them "
                        "with a table of such samples (setting samples)"
                    )

    def examples(self, wanted: Mapping[str, str]) -> dict[str, str]:
        """The piece that stands for each mode in figures: that of the wanted sample, or the first.

        Parameters
        ----------
        wanted
            Samples by mode; a name that is no sample of the mode counts as none.
        """
        found = {}
        for mode in MODES:
            there = [name for name, row in self.rows.items() if row["mode"] == mode]
            if there:
                name = wanted.get(mode)
                found[mode] = self.piece_of[name if name in there else there[0]]
        return found

    def shown(self, examples: Mapping[str, str]) -> str:
        """The piece of figure 2: the compression example, else another one; best with an image."""
        candidates = self.imaged or self.pieces
        preferred = [examples.get("compression"), *examples.values(), *candidates]
        return next(name for name in preferred if name in candidates)

    @cached_property
    def ideal_shape(self) -> str:
        """What samples are idealised as: `cuboid`, `cylinder`, or both."""
        kinds = {resolved(row)["shape"] for row in self.rows.values()}
        return kinds.pop() if len(kinds) == 1 else "cuboid or cylinder"


def _known(name: str, there: Mapping[str, Any], kind: str) -> str:
    if name not in there:
        raise InputError(f"no {kind} {name!r} in the table; there are {', '.join(there)}")
    return name
