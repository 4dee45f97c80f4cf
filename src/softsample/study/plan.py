"""What a study computes for the rows of its table: geometries, equal pieces, models."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from softsample.errors import InputError
from softsample.holdout import Row
from softsample.protocol import PRESSED_MODES
from softsample.shapes import BONDED
from softsample.validation import DEFAULT_AXES, ends_of, resolved

GEOMETRIES = ("real", "ideal")

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

TWO_TERM, ONE_TERM = "ogden2", "ogden1"


@dataclass(frozen=True)
class Plan:
    """Geometries, pieces and models of a study.

    A piece stands for all samples of one group with the same geometry, mode and ends: they
    share mesh, curves and everything that is computed from these. It has the name of the first.

    Parameters
    ----------
    rows : mapping
        Rows of the table of samples by sample, empty cells left out.
    held_out : set of str
        Samples that are held out as a whole, not all of a group
        (`softsample.holdout.check_hold_out`): a model of theirs alone cannot be calibrated.

    Raises
    ------
    InputError
        If a name is a sample of one group and the name of another one that has other geometries.
    """

    rows: Mapping[str, Row]
    held_out: frozenset[str] = field(default_factory=frozenset)

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

    def has_image(self, sample: str) -> bool:
        """Whether the sample comes with an image."""
        return "image" in self.rows[sample]

    def has_real(self, sample: str) -> bool:
        """Whether the sample's true shape is known, by an image or a surface."""
        return self.has_image(sample) or "surface" in self.rows[sample]

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
        return self._geometries[name if name in self.groups else self.rows[name]["group"]]

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

    def records_of(self, piece: str) -> list[str]:
        """Samples that share a piece."""
        return [sample for sample, owner in self.piece_of.items() if owner == piece]

    def pieces_of(self, group: str) -> list[str]:
        """Pieces of a group."""
        return [piece for piece in self.pieces if self.rows[piece]["group"] == group]

    def members(self, group: str, model: str) -> list[str]:
        """Samples of a group that a model is calibrated on.

        The one-term model is calibrated on compression alone, as in Table 2 of the paper.
        """
        samples = self.groups[group]
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
        group = self.rows[sample]["group"]
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

    def check_alike(self) -> None:
        """Refuse what experiments on shape and exponents of whole cohorts are not made for.

        Raises
        ------
        InputError
            If a shape is not known, ends are not bonded, or a piece has several tests.
        """
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

    @cached_property
    def ideal_shape(self) -> str:
        """What samples are idealised as: `cuboid`, `cylinder`, or both."""
        kinds = {resolved(row)["shape"] for row in self.rows.values()}
        return kinds.pop() if len(kinds) == 1 else "cuboid or cylinder"
