"""A group, or all groups that tell of each other, beside their responses: from files of a study."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import pandas as pd

from softsample.constitutive.material import Material
from softsample.io import read_json, read_record, read_shape, read_table
from softsample.loop.candidates import candidates
from softsample.loop.effects.base import Effect
from softsample.loop.ends import AssumedEnds, with_ends
from softsample.loop.held_out import specimens_of
from softsample.loop.pool import Group, Pooled
from softsample.loop.posed import LoopSettings, Posed
from softsample.loop.specimen import Specimen
from softsample.records import Record
from softsample.response.elastic import Tables
from softsample.shapes import IdealShape

Files = Mapping[str, Any]
"""Files, or lists of files, by name: input of a rule."""


def assumed_ends(files: Files, given: Any, solid: Material) -> list[AssumedEnds]:
    """A group beside its responses: of the study's ends, or of bonded and of sliding ones.

    Parameters
    ----------
    files : mapping
        Input of the rule `diagnose`.
    given : object
        Its parameters.
    solid : Material
        The law of the study.
    """
    recorded = _Recorded.of(files, given, solid)
    told = [read_json(path)["groups"][given.group] for path in files.get("told", [])]
    models = []
    for k in range(len(recorded.tables)):
        every = recorded.tests(k, given.hold_out)
        own = [test for test in every if test.name in given.samples]
        pooled = Pooled.of_document(told[k]) if told and told[k] else None
        models.append(AssumedEnds(own, every, recorded.effects(own), pooled))
    return models


def groups_in_turn(
    files: Files, given: Any, settings: LoopSettings, solid: Material
) -> dict[str, Group]:
    """Groups that tell of each other, by name, with the study's ends, or bonded or sliding ones.

    Parameters
    ----------
    files, given
        Input and parameters of the rule `pool`.
    solid : Material
        The law of the study.
    """
    recorded = _Recorded.of(files, given, solid)
    every, groups = [recorded.tests(0, []), recorded.tests(0, given.hold_out)], {}
    verdicts = [[read_json(path) for path in files[kind]] for kind in ("whole", "alone")]
    for (name, samples), whole, alone in zip(given.groups.items(), *verdicts, strict=True):
        own = [[test for test in tests if test.name in samples] for tests in every]
        posed = [Posed.of(tests, settings) for tests in own]
        effects = [
            one.open_to(recorded.effects(tests), settings)
            for one, tests in zip(posed, own, strict=True)
        ]
        found = [with_ends(verdict, given.sliding) for verdict in (whole, alone)]
        groups[name] = Group.of(posed, effects, found, alone)
    return groups


@dataclass(frozen=True)
class _Recorded:
    """Samples of a study beside their responses.

    Parameters
    ----------
    rows, records, shapes : list
        Of every sample: row with defaults filled in, record, ideal shape.
    tables : list of list of Tables
        Responses of every sample: with the ends of the study, or with bonded and sliding ones.
    solid : Material
        The law of the study.
    """

    rows: list[Mapping[str, str]]
    records: list[Record]
    shapes: list[IdealShape]
    tables: list[list[Tables]]
    solid: Material

    @classmethod
    def of(cls, files: Files, given: Any, solid: Material) -> Self:
        """From the input of a rule and its parameters."""
        reports = map(read_json, files.get("bonds", []))
        bonds = [next(reports, None) if bonded else None for bonded in given.bonded]
        tables = []
        for ends in ("", "sliding_")[: 2 if files.get("sliding_curves") else 1]:
            known = [*map(read_table, files.get(f"{ends}real", []))]
            real: Sequence[pd.DataFrame | None] = known or [None] * len(bonds)
            curves, changes = files[f"{ends}curves"], map(read_table, files[f"{ends}perturbations"])
            of_curves = {
                path: Tables(read_table(path), [change], solid, table, bond, given.release)
                for path, change, table, bond in zip(curves, changes, real, bonds, strict=True)
            }
            tables.append([of_curves[path] for path in curves])
        records = [*map(read_record, files["records"])]
        shapes = [*map(read_shape, files["cuboids"])]
        return cls(given.rows, records, shapes, tables, solid)

    def tests(self, ends: int, hold_out: Sequence[Mapping[str, Any]]) -> list[Specimen]:
        """All tests, of which selections are held out, with one model of the ends."""
        samples = zip(self.rows, self.records, self.tables[ends], self.shapes, strict=True)
        return [test for sample in samples for test in specimens_of(*sample, hold_out)]

    def effects(self, tests: Sequence[Specimen]) -> list[Effect]:
        """Effects that tests of one group may show."""
        heights = {row["sample"]: s.height for row, s in zip(self.rows, self.shapes, strict=True)}
        return candidates(tests, heights[tests[0].name], self.solid)
