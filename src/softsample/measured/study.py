"""The loop on a case: calibrate, verdict, error before and after on what was held out."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from softsample.loop.diagnose import Diagnosis, LoopSettings, diagnose, report
from softsample.loop.effects.base import Effect
from softsample.loop.errors import Error, informed
from softsample.loop.fit import Fit
from softsample.loop.specimen import Elastic, Specimen
from softsample.measured.effects import fitted_library
from softsample.measured.models import Key, key_of
from softsample.measured.split import Case, Part

OPEN_MODULUS = float(np.log(2.0))
"""Standard deviation of log(mu) above which a fit leaves the modulus open: a factor of two."""

AT_END = 1e-3
"""A mixture this close to an end of its range is at it."""

MOST_SAMPLES = 4000
"""Longer records are averaged over groups of samples before anything else."""

LEAST_FALL = 0.1
"""Part by which the error of every fold has to fall for an effect to be given."""


@dataclass(frozen=True)
class Answer:
    """What the loop says of a case.

    Parameters
    ----------
    case, kind : str
        Name of the case and kind of its model.
    verdict : str
        `explained` only where the folds of the fitted part support the effects; effects that
        they do not are withheld, and the verdict is `unknown`.
    diagnosis : Diagnosis
        Of the fitted part.
    before, after : float
        Error on the held-out part [% of its peak]; equal where no effect is given.
    before_by, after_by : dict
        The same by mode and channel.
    records : int
        Records fitted and held out.
    """

    case: str
    kind: str
    verdict: str
    diagnosis: Diagnosis
    before_by: Mapping[str, float]
    after_by: Mapping[str, float]
    records: int

    @property
    def before(self) -> float:
        """Error before [% of peak]."""
        return float(np.median(list(self.before_by.values())))

    @property
    def after(self) -> float:
        """Error after [% of peak]."""
        return float(np.median(list(self.after_by.values())))

    def report(self, settings: LoopSettings) -> dict[str, Any]:
        """Entry of `verdict.json`."""
        full = report(self.diagnosis, settings)
        given = self.verdict == "explained"
        return {
            "record_group": self.case,
            "model": self.kind,
            "verdict": self.verdict,
            "effects": full["effects"] if given else [],
            "withheld": [] if given else [effect["name"] for effect in full["effects"]],
            "held_out_before_percent": self.before,
            "held_out_after_percent": self.after,
            "held_out_by": {
                name: {"before_percent": error, "after_percent": self.after_by[name]}
                for name, error in self.before_by.items()
            },
            "records": self.records,
            "folds_before": full["held_out_before"],
            "folds_after": full["held_out_after"],
            **{
                key: full[key]
                for key in (
                    "theta_before", "theta_after", "error_before", "error_after",
                    "white_mean_square", "not_identifiable", "detection_limits", "path",
                )
            },
        }  # fmt: skip


def answer(
    case: Case,
    kind: str,
    models: Mapping[Key, Elastic],
    alpha: tuple[float, float],
    settings: LoopSettings,
) -> Answer:
    """Trace what a calibration on the fitted part leaves over, and judge it on the held-out part.

    The floor of repeats of one test is theirs together: it is that of the settings times the root
    of their number in each, so that repeating a test does not make its model more exact.
    """
    fitted = [specimen(part, kind, models) for part in case.fitted]
    repeats = Counter((part.test.specimen, part.test.mode) for part in case.fitted)
    share = float(np.sqrt(max(repeats.values())))
    noise = replace(
        settings.noise,
        floor_percent=share * settings.noise.floor_percent,
        fine_percent=share * settings.noise.fine_percent,
    )
    found = diagnose(fitted, replace(settings, noise=noise), library_of(case, kind, fitted, alpha))
    verdict = found.verdict
    if verdict == "explained" and not supported(found):
        verdict = "unknown"
    base = found.selection.base
    final = found.selection.final if verdict == "explained" else base
    return Answer(
        case.name,
        kind,
        verdict,
        found,
        held_out_error(base, case, kind, models),
        held_out_error(final, case, kind, models),
        len({part.test.name for part in case.fitted + case.held_out}),
    )


def library_of(
    case: Case, kind: str, fitted: list[Specimen], alpha: tuple[float, float]
) -> list[Effect]:
    """Effects with ranges for the records of a case."""
    first = case.fitted[0].test
    peak = float(np.median([specimen.peak for specimen in fitted]))
    return fitted_library(alpha, first.shape.height, peak, first.timed, kind == "bonded")


def specimen(part: Part, kind: str, models: Mapping[Key, Elastic]) -> Specimen:
    """A part of a record, up to its last sample, as the loop sees it."""
    test = part.test
    table = test.table.iloc[: part.until]
    if part.channel == "force_normal":
        table = table.assign(force_N=table["force_normal_N"])
    found = Specimen.of_record(
        test.name, test.mode, table, models[key_of(kind, test, part.channel)]
    )
    return found.reduced(max(1, -(-len(table) // MOST_SAMPLES)))


def supported(found: Diagnosis) -> bool:
    """Whether the fitted part supports the effects that explain it.

    Every fold of it has to be predicted better with them than without by the part `LEAST_FALL`,
    no size may have been driven to the end of its plausible range, where the form does not hold,
    and the modulus has to stay known: with effects that can stand for all of it, anything fits.
    """
    before, after = (
        {fold: _root_mean_square(tests) for fold, tests in errors.items()}
        for errors in (found.held_out_before, found.held_out_after)
    )
    better = all(after[fold] < (1.0 - LEAST_FALL) * before[fold] for fold in before)
    final = found.selection.final
    return (
        bool(before)
        and better
        and _material_known(final, found.problem.mixtures)
        and not _driven_to_an_end(final)
    )


def _material_known(fit: Fit, mixtures: tuple[float, float]) -> bool:
    """Whether the modulus is known and the mixture is not at an end of its range."""
    low, high = mixtures
    inside = low + AT_END < fit.state.material.mixture < high - AT_END
    return bool(inside and np.sqrt(fit.covariance[0, 0]) < OPEN_MODULUS)


def _driven_to_an_end(fit: Fit) -> bool:
    """Whether a size lies at an end of its range at which it is not absent."""
    for effect, p in fit.model.parameters:
        away = abs(fit.state.values[effect.name][p.name] - p.neutral)
        at_end = f"{effect.name}.{p.name}" in fit.at_bound
        if p.is_size and at_end and away > 0.01 * (p.high - p.low):
            return True
    return False


def _root_mean_square(tests: Mapping[str, Error]) -> float:
    """Error over the tests of a fold, in parts of their peaks."""
    return float(np.sqrt(np.mean([(e.structured / e.peak) ** 2 for e in tests.values()])))


def held_out_error(
    fit: Fit, case: Case, kind: str, models: Mapping[Key, Elastic]
) -> dict[str, float]:
    """Error of a fit on the held-out part by mode and channel: RMS over records [% of peak].

    Sizes that the fitted part does not show are neutral, and so is what an effect does to the
    channel of a force if another one is predicted.
    """
    squares: dict[str, list[float]] = {}
    for part in case.held_out:
        there = specimen(part, kind, models)
        state = informed(fit)
        model = fit.model
        if part.channel != "force":
            model = replace(model, effects=tuple(e for e in model.effects if not e.acts_on_channel))
        chosen = part.counts(there.travel / part.test.shape.height)
        left = (there.force - model.predict(there, state))[chosen]
        label = part.test.mode if part.channel == "force" else "normal force"
        squares.setdefault(label, []).append(
            float(np.mean(left**2)) / float(np.abs(there.force[chosen]).max()) ** 2
        )
    return {label: 100.0 * float(np.sqrt(np.mean(parts))) for label, parts in squares.items()}
