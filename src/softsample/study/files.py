"""Which files the jobs of a study read and make, as Snakemake names them."""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from softsample.errors import InputError
from softsample.formats import files_of
from softsample.protocol import GEOMETRIES, ONE_TERM, TWO_TERM
from softsample.study.plan import Plan
from softsample.validation import FILE_COLUMNS, has_open_ends

RESULTS = "<results>/"
"""What Snakemake puts the folder of results for."""

PICTURE_FORMATS = ("png", "pdf")

EXPORTS = (".inp", "_calculix.inp", ".feb", ".pvd")
"""Endings of a test's files for other programs."""

REPORTED = {
    "check_image", "check_record", "segment", "measure", "mesh", "simulate", "calibrate",
    "confirm", "one_term", "band", "bond", "calibrate_bond", "sensitivity", "perturbations",
    "diagnose", "checks", "figure_sample", "figure_response", "figure_strain",
}  # fmt: skip
"""Stages that the report rests on; an export, say, may have failed."""


@dataclass(frozen=True)
class Files:
    """Files of a study; `[]` stands for none where Snakemake expects one.

    Parameters
    ----------
    plan : Plan
        Of the study.
    folder : path
        Of the table of samples, which the files it names are relative to.
    """

    plan: Plan
    folder: str | os.PathLike[str] = ""

    def given(self, column: str, sample: str) -> str | list[str]:
        """The file that a column of the sample's row names."""
        name = self.plan.row(sample).get(column, "")
        return os.path.normpath(os.path.join(self.folder, name)) if name else []

    def there(self, column: str, sample: str) -> str | list[str]:
        """The same if it is there, as an input: Snakemake stops all samples if one is missing.

        The rules `check_image` and `check_record` refuse what is `missing`, and what is made from
        either waits for its check.
        """
        path = self.given(column, sample)
        return path if isinstance(path, str) and os.path.exists(path) else []

    def missing(self, sample: str, columns: Iterable[str] = FILE_COLUMNS) -> dict[str, str]:
        """Files that columns of the sample's row name and that are not there, by column."""
        named = {name: str(path) for name in columns if (path := self.given(name, sample))}
        return {name: path for name, path in named.items() if not self.there(name, sample)}

    def image(self, column: str, sample: str, geometry: str = "real") -> list[str]:
        """The image that a column names, first, and the files it consists of; none for `ideal`."""
        path = self.there(column, sample)
        return files_of(path) if isinstance(path, str) and geometry != "ideal" else []

    def segmentation(self, ending: str, sample: str) -> str | list[str]:
        """A result of the segmentation; none of a sample whose dimensions are stated."""
        there = self.plan.has_real(sample)
        return f"{RESULTS}segmentation/{sample}{ending}" if there else []

    def for_geometry(self, ending: str, sample: str, geometry: str) -> str | list[str]:
        """The same for a geometry: none for the ideal one, and refused where it is not known."""
        if geometry == "ideal":
            return []
        if not self.plan.has_real(sample):
            raise InputError(
                f"the dimensions of sample {sample!r} are stated in the table: it has no real "
                "geometry; ask for the ideal one, or give an image or a surface"
            )
        return self.segmentation(ending, sample)

    def mesh_of_runs(
        self, ending: str, ends: str | None, sample: str, geometry: str
    ) -> str | list[str]:
        """A mesh of the sample, none if its response has a closed form."""
        exact = self.plan.has_closed_form(sample, geometry, ends)
        return [] if exact else f"{RESULTS}mesh/{sample}/{geometry}{ending}.vtu"

    def each(self, pattern: str, samples: Iterable[str], **fixed: str) -> list[str]:
        """The pattern, filled for each of the samples.

        It may hold `sample`, `piece`, `geometry` (the nearest to the sample if it is not `fixed`),
        `ends` (`_sliding` where these are open) and what is `fixed`.
        """
        plan = self.plan
        return [
            pattern.format_map(
                {
                    "geometry": plan.best(name),
                    **fixed,
                    "sample": name,
                    "piece": plan.piece_of[name],
                    "ends": "_sliding" if has_open_ends(plan.rows[name]) else "",
                }
            )
            for name in samples
        ]

    def calibration(self, ending: str, sample: str, geometry: str) -> str:
        """Calibration of the sample's group."""
        group = self.plan.row(sample)["group"]
        return f"{RESULTS}calibration/{group}/{geometry}/{TWO_TERM}.{ending}"

    def calibration_of_group(self, group: str, geometry: str = "") -> str:
        """Calibration of a group, on its best geometry if none is given."""
        return self.calibration(
            "json", self.plan.samples_of(group)[0], geometry or self.plan.best(group)
        )

    def calibration_of_pool(self, geometry: str) -> str:
        """Calibration of the first of the groups that tell of each other."""
        return self.calibration_of_group(next(iter(self.plan.in_turn(geometry))), geometry)

    def fitted_curves(self, sample: str) -> list[str]:
        """Calibrated curves of the sample's group on its geometries."""
        return [self.calibration("csv", sample, name) for name in self.plan.geometries(sample)]

    def curve_reports(self, sample: str, geometry: str) -> list[str]:
        """Reports of the sample's responses, one a model."""
        models = self.plan.sample_models(sample)
        return [f"{RESULTS}curves/{sample}/{geometry}/{model}.json" for model in models]

    def calibrations(self, groups: Iterable[str]) -> list[str]:
        """Calibrations of groups: every geometry and model."""
        return [
            f"{RESULTS}calibration/{group}/{geometry}/{model}.json"
            for group in groups
            for geometry in self.plan.geometries(group)
            for model in self.plan.models(group)
        ]

    def fitted_groups(self, model: str) -> dict[str, list[str]]:
        """Groups with a calibration of the model, by geometry."""
        groups = [name for name in self.plan.groups if model in self.plan.models(name)]
        return {
            geometry: [name for name in groups if geometry in self.plan.geometries(name)]
            for geometry in GEOMETRIES
        }

    def fits(self, model: str, ending: str) -> dict[str, list[str]]:
        """Calibrations of one model by geometry, in the order of `fitted_groups(model)`."""
        return {
            geometry: [
                f"{RESULTS}calibration/{name}/{geometry}/{model}.{ending}" for name in groups
            ]
            for geometry, groups in self.fitted_groups(model).items()
        }

    @cached_property
    def verdicts(self) -> dict[tuple[str, str], str]:
        """Verdicts by group and geometry."""
        plan = self.plan
        best = {
            (name, plan.best(name)): f"{RESULTS}loop/{name}/verdict.json" for name in plan.groups
        }
        ideal = {
            (name, "ideal"): f"{RESULTS}loop/{name}/ideal/verdict.json"
            for name in plan.groups
            if plan.best(name) == "real"
        }
        return best | ideal

    def verdicts_in_turn(self, kind: str, geometry: str) -> list[str]:
        """Verdicts of the groups that tell of each other, `alone`, or on `whole` records."""
        return [f"{RESULTS}loop/{name}/{kind}/verdict.json" for name in self.plan.in_turn(geometry)]

    def told(self, group: str) -> list[str]:
        """What other groups tell of one, if they do: with sliding ends too, if these are open."""
        plan, geometry = self.plan, self.plan.best(group)
        ends = ("", "_sliding") if plan.opened(plan.pool(geometry)) else ("",)
        return [f"{RESULTS}loop/pool_{geometry}{e}.json" for e in ends if plan.is_told(group)]

    def open_ends_verdicts(self, group: str) -> list[str]:
        """Verdicts that tell what the platens do to ends that are open."""
        return [f"{RESULTS}loop/{name}/alone/verdict.json" for name in self.plan.open_others(group)]

    def sensitivities(self, pieces: Iterable[str]) -> list[str]:
        """Sensitivities to numerical choices, on the best geometry that each piece has."""
        return self.each(RESULTS + "sensitivity/{sample}/{geometry}.json", pieces)

    def of_runs(self, pattern: str, pieces: Sequence[str] | None = None) -> list[str]:
        """The pattern, filled with piece and geometry of all runs, or of those of some pieces."""
        runs = [run for run in self.plan.runs if pieces is None or run[0] in pieces]
        return [f"{RESULTS}{pattern.format(piece, geometry)}" for piece, geometry in runs]

    @property
    def checks(self) -> list[str]:
        """Checks of every run and every calibration."""
        of_groups = [f"{RESULTS}checks/{name}_calibration.json" for name in self.plan.groups]
        return self.of_runs("checks/{}_{}.json") + of_groups

    def of_sample(self, sample: str) -> list[str]:
        """What `sample_{id}` builds: the sample's files, its group's calibration and checks."""
        group = self.plan.row(sample)["group"]
        pieces = self.plan.pieces_of(group)
        return [
            *self.calibrations([group]),
            *self.of_runs("fields/{}/{}.vtu", pieces),
            *self.of_runs("checks/{}_{}.json", pieces),
            *self.sensitivities(pieces),
        ]

    def exports(self, sample: str) -> list[str]:
        """What `export_{id}` builds: the sample's test at the optimum for other programs."""
        geometries = self.plan.geometries(sample)
        return [f"{RESULTS}export/{sample}/{name}{end}" for name in geometries for end in EXPORTS]

    @property
    def moduli_tables(self) -> dict[str, str]:
        """Table of moduli by model; none for a model that no group has."""
        names = {TWO_TERM: "table1", ONE_TERM: "table2"}
        there = {model for name in self.plan.groups for model in self.plan.models(name)}
        return {m: f"{RESULTS}tables/{name}.csv" for m, name in names.items() if m in there}

    @property
    def tables(self) -> list[str]:
        """The tables of the study, and the numbers that the captions quote."""
        names = {
            "geometry.csv": True, "summary.csv": True, "stress_strain.csv": True,
            "sensitivity.csv": True, "band.csv": self.plan.banded, "bond.csv": self.plan.bonded,
            "intervals.csv": True, "loop.csv": True, "numbers.rst": True,
            "contact.csv": self.plan.compressed,
        }  # fmt: skip
        others = [f"{RESULTS}tables/{name}" for name, there in names.items() if there]
        return [*self.moduli_tables.values(), *others]

    @property
    def figures(self) -> list[str]:
        """The figures of the study, numbered as in the paper."""
        pressed = self.plan.compressed
        there = {
            "figure2": self.plan.imaged, "figure3": True, "figure4": True, "figure5": True,
            "figure6": pressed, "figure7": True, "contact": pressed,
        }  # fmt: skip
        return in_formats(name for name, asked in there.items() if asked)

    @property
    def pictured(self) -> dict[str, list[str]]:
        """Samples by the kind of picture that there is of each of them."""
        plan = self.plan
        return {"samples": plan.imaged, "response": list(plan.rows), "strain": plan.pieces}

    @property
    def pictures(self) -> list[str]:
        """The pictures of single samples."""
        return [
            f"{RESULTS}figures/{kind}/{name}.png"
            for kind, names in self.pictured.items()
            for name in names
        ]

    @property
    def geometry_effects(self) -> list[str]:
        """Tables and figures of the experiments on the geometry; contact needs compression."""
        tables = ["geometry_effects", "bias_shares", "cohort_needed"]
        pressed = ["prescribed"] if self.plan.compressed else []
        return [
            *(f"{RESULTS}tables/{name}.csv" for name in tables + pressed),
            *in_formats(["geometry_effects", *pressed]),
        ]

    def reported(self, group: str) -> list[str]:
        """What of a group the report rests on."""
        plan, pieces = self.plan, self.plan.pieces_of(group)
        bonded = [piece for piece in pieces if piece in plan.bonded]
        return [
            *self.of_runs("fields/{}/{}.json", pieces),
            *self.sensitivities(pieces),
            *(f"{RESULTS}band/{piece}.json" for piece in pieces if piece in plan.banded),
            *(f"{RESULTS}bond/{piece}.json" for piece in bonded),
            *([f"{RESULTS}bond/moduli/{group}.json"] if bonded else []),
            *(path for (name, _), path in self.verdicts.items() if name == group),
        ]

    def finished(
        self,
        results: str | os.PathLike[str],
        failures: Iterable[tuple[str, str]],
        reported: bool = True,
    ) -> Mapping[str, Mapping[str, str]]:
        """Rows of groups that have, below `results`, what the report needs, and no job that failed.

        `failures` are names and reasons of jobs (`softsample.workflow.failed_jobs`). Unless the
        groups are to be `reported`, it is enough that no job failed.
        """
        plan = self.plan
        names = sorted({*plan.rows, *plan.groups}, key=len, reverse=True)

        def owner(job: str) -> str | None:
            stage, _, rest = job.partition("/")
            own = (name for name in names if rest == name or rest.startswith(f"{name}_"))
            return next(own, None) if stage in REPORTED else None

        def there(path: str) -> bool:
            return Path(results, path.removeprefix(RESULTS)).is_file()

        failed = {owner(job) for job, _ in failures}
        through = [
            group
            for group, samples in plan.groups.items()
            if not {group, *samples} & failed
            and not (reported and any(not there(path) for path in self.reported(group)))
        ]
        return {name: row for name, row in plan.rows.items() if row["group"] in through}


def in_formats(names: Iterable[str], folder: str = "figures") -> list[str]:
    """Figures in all formats."""
    return [f"{RESULTS}{folder}/{name}.{kind}" for name in names for kind in PICTURE_FORMATS]
