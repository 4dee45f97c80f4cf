"""The report of a study, put together from what its files hold."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any

import pandas as pd

from softsample.report import html
from softsample.report.facts import findings_of, record_fact, sample_facts, verdict_sentence
from softsample.report.results import Report, brief
from softsample.report.scene import Shape, scene
from softsample.report.tables import intervals_shown, table_shown
from softsample.wording import verdict_words

Run = tuple[str, str]
"""Piece and geometry."""

CAPTIONS = {"samples": "sample", "response": "response", "strain": "strain"}
"""Caption of each kind of picture of a sample, in the order of its page."""


@dataclass(frozen=True)
class StudyReport:
    """What the files of a study hold.

    Parameters
    ----------
    rows : mapping
        Rows of the study table by sample.
    groups : mapping
        Samples by group.
    piece_of : mapping
        Piece by sample.
    images, records, segmentation, cuboid : mapping of Report
        `inputs/images/`, `inputs/` and `segmentation/{sample}.json` by sample,
        `cuboid/{sample}.json` by piece.
    meshes, runs : mapping of Report
        `mesh/` and `fields/{sample}/{geometry}.json`.
    surfaces : mapping of Shape
        Surfaces of the same runs.
    pictures : mapping
        Files by sample, by kind of picture.
    fits : sequence of Report
        `calibration/{group}/{geometry}/{model}.json`.
    verdicts : mapping of Report
        `loop/{group}/verdict.json` by group.
    verdict_pages, verdict_plots : mapping of Path
        `loop/{group}/verdict.md` and `verdict.png` by group.
    intervals : DataFrame
        `tables/intervals.csv`.
    parts : Path
        Folder of the templates of captions.
    config : mapping
        The config.
    """

    rows: Mapping[str, Mapping[str, str]]
    groups: Mapping[str, Sequence[str]]
    piece_of: Mapping[str, str]
    images: Mapping[str, Report]
    records: Mapping[str, Report]
    segmentation: Mapping[str, Report]
    cuboid: Mapping[str, Report]
    meshes: Mapping[Run, Report]
    runs: Mapping[Run, Report]
    surfaces: Mapping[Run, Shape]
    pictures: Mapping[str, Mapping[str, Path]]
    fits: Sequence[Report]
    verdicts: Mapping[str, Report]
    verdict_pages: Mapping[str, Path]
    verdict_plots: Mapping[str, Path]
    intervals: pd.DataFrame
    parts: Path
    config: Mapping[str, Any]

    def page(
        self,
        template: Path,
        document: Report,
        tables: Mapping[Path, pd.DataFrame],
        figures: Iterable[Path],
        checks: Mapping[str, Sequence[Report]],
        schema: Mapping[str, Any],
        colours: Sequence[str],
        **parts: Any,
    ) -> str:
        """The page in HTML.

        Parameters
        ----------
        template
            Of the page.
        document : Report
            `results.json`, for the card of each group.
        tables : mapping of DataFrame
            By file.
        figures : iterable of Path
            Files.
        checks : mapping
            Checks by what they are of.
        schema : mapping
            Of the config, for the table of settings.
        colours : sequence of str
            Of strain, from none on.
        parts
            What the template takes as it is.
        """
        real = any(geometry == "real" for _, geometry in self.runs)
        return html.render_report(
            template,
            cards=[card | {"verdict": verdict_words(card["verdict"])} for card in brief(document)],
            real=real,
            summary=self._caption("workflow" if real else "workflow_ideal"),
            tables=[self._table(path, frame) for path, frame in tables.items()],
            figures=[
                {
                    "name": path.stem,
                    "picture": html.picture(path, path.stem),
                    "caption": self._caption(path.stem),
                }
                for path in figures
            ],
            groups=[self._group(name) for name in self.groups],
            imaged=bool(self.pictures["samples"]),
            config=self.config,
            parameters=list(html.parameters(self.config, schema)),
            checks=[{"of": of, **check} for of, found in checks.items() for check in found],
            stages={
                report["provenance"]["rule"]: report["provenance"]["code_sha256"]
                for report in self._reports
            },
            inputs={
                name: digest
                for report in chain(self.images.values(), self.records.values())
                for name, digest in report["provenance"]["inputs"].items()
            },
            scenes=html.as_json(
                {
                    "colours": colours,
                    "extent_mm": max(one["extent_mm"] for one in self._scenes.values()),
                    "samples": self._scenes,
                }
            ),
            **parts,
        )

    @property
    def _reports(self) -> Iterable[Report]:
        """All result files that name the code they were made by."""
        of_samples = self.images, self.records, self.segmentation, self.cuboid
        kinds = *of_samples, self.meshes, self.runs, self.verdicts
        return chain(*(kind.values() for kind in kinds), self.fits)

    @cached_property
    def _scenes(self) -> dict[str, dict[str, Any]]:
        """Interactive views of the samples that were simulated."""
        return {
            name: scene(found) for name in self.rows if (found := of_piece(self.surfaces, name))
        }

    def _caption(self, name: str, **wildcards: str) -> str:
        return html.caption(self.parts / f"{name}.rst", self.config, **wildcards)

    def _table(self, path: Path, frame: pd.DataFrame) -> dict[str, Any]:
        group_of = {name: row["group"] for name, row in self.rows.items()}
        return {
            "name": path.stem,
            "frame": table_shown(
                path.stem, frame, self.intervals, group_of, self.config["uncertainty"]["confidence"]
            ),
            "caption": self._caption(path.stem),
            "download": html.download(path),
        }

    def _sample(self, name: str) -> dict[str, Any]:
        """One sample: pictures with captions, and facts, which equal pieces share."""
        record, meshes = self.records[name]["record"], of_piece(self.meshes, name)
        facts: Mapping[str, Any] = {"facts": [("Record", record_fact(record))]}
        if meshes:
            image = self.images.get(name, {}).get("image")
            shape = image, self.segmentation.get(name), self.cuboid[name]
            facts = {
                "limits": self._scenes[name]["limits"],
                "geometries": list(meshes),
                "facts": sample_facts(record, *shape, meshes, of_piece(self.runs, name)),
            }
        return {
            "name": name,
            "mode": self.rows[name]["mode"].replace("_", " "),
            "piece": self.piece_of[name],
            "pictures": [
                {
                    "picture": html.picture(self.pictures[kind][name], f"{name}, {kind}"),
                    "caption": self._caption(text, sample=name),
                }
                for kind, text in CAPTIONS.items()
                if name in self.pictures[kind]
            ],
            **facts,
        }

    def _group(self, name: str) -> dict[str, Any]:
        """One group: its samples, moduli and verdict."""
        members, verdict = self.groups[name], self.verdicts[name]
        page = self.verdict_pages[name].read_text(encoding="utf-8")
        return {
            "name": name,
            "samples": [self._sample(member) for member in members],
            "real": "real" in of_piece(self.runs, self.piece_of[members[0]]),
            "findings": findings_of([fit for fit in self.fits if fit["group"] == name]),
            "moduli": intervals_shown(
                self.intervals[self.intervals["group"] == name],
                self.config["uncertainty"]["confidence"],
            ).drop(columns="group"),
            "verdict": verdict_words(verdict["verdict"]),
            "saying": verdict_sentence(verdict),
            "page": html.markdown(page, {"verdict.png": self.verdict_plots[name]}),
        }


def of_piece(found: Mapping[Run, Any], piece: str) -> dict[str, Any]:
    """What was found of one piece, by geometry."""
    return {geometry: one for (name, geometry), one in found.items() if name == piece}


def by_name(names: Iterable[Any], found: Iterable[Any]) -> dict[Any, Any]:
    """What was found, by name; of names that stand there several times, one each."""
    return dict(zip(dict.fromkeys(names), found, strict=True))
