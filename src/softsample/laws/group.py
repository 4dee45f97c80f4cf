"""All laws of the dictionary on the tests of one group, and on what is left of them in turn."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import pandas as pd

from softsample.arrays import Mask
from softsample.errors import CalibrationError
from softsample.laws.candidates import Candidate
from softsample.laws.fit import LawFit, Problem
from softsample.laws.folds import Fits, error_on
from softsample.laws.intervals import covariance_of_shape, intervals, left_open, simpler_laws
from softsample.laws.simulate import simulate_law
from softsample.laws.test import LawTest
from softsample.protocol import travel_sign
from softsample.response.unit import Progress

ALL = "all"
"""Name of the part of a group that leaves nothing out but what the study holds out."""


@dataclass(frozen=True)
class LawSettings:
    """Mirrors config `laws:`.

    Parameters
    ----------
    candidates : sequence of str
        Laws, and sums of two joined by `+`.
    pool : bool
        Whether the folds of all groups choose one law for all.
    element_size_mm : float
        Edge of the elements of the runs [mm].
    curve_error_percent : float
        Largest error of a response between runs at an optimum [% of peak].
    """

    candidates: Sequence[str]
    pool: bool = True
    element_size_mm: float = 1.0
    curve_error_percent: float = 0.3

    @property
    def tolerance(self) -> float:
        """The error, as a part of the peak."""
        return 0.01 * self.curve_error_percent

    def laws(self, alpha: Sequence[float]) -> list[Candidate]:
        """The candidates, and the study's pair of exponents last."""
        return [*map(Candidate.of, self.candidates), Candidate.of_pair(alpha)]


def parts_of(tests: Sequence[LawTest], folds: Mapping[str, Sequence[str]]) -> dict[str, list[Mask]]:
    """Points that are fitted, by what of the group is left out: nothing, or the samples of a fold.

    Parameters
    ----------
    folds : mapping
        Samples that are left out, by name of the fold.
    """
    seen = {ALL: [~test.held_out for test in tests]}
    for name, samples in folds.items():
        masks = [~t.held_out & (t.sample not in samples) for t in tests]
        if any(mask.any() for mask in masks):
            seen[name] = masks
    return seen


def law_report(
    candidate: Candidate, fits: Fits, parts: Mapping[str, Sequence[Mask]], confidence: float
) -> tuple[dict[str, Any], Problem, LawFit]:
    """One law on a group: parameters with intervals, what they say, and errors of all parts.

    Parameters, of folds too, are those of the likelihood that the intervals are of.

    Parameters
    ----------
    fits : Fits
        Of the tests of the group.
    parts : mapping
        Points that are fitted, by name, `ALL` first.
    confidence : float
        Of the intervals.
    """
    tests, kept = fits.tests, parts[ALL]
    found, best = fits.of(candidate, kept)
    report = {
        "title": candidate.title,
        "parameters": candidate.size,
        "mu_pa": best.mu,
        "shape": {s.name: float(v) for s, v in zip(candidate.shape, best.shape, strict=True)},
        "intervals": {
            name: asdict(interval)
            for name, interval in intervals(found.weighted, best, confidence).items()
        } if best.mu > 0.0 else {},
        "covariance_of_shape": covariance_of_shape(found.weighted, best).tolist(),
        "open": left_open(found.weighted, best),
        "at_bound": best.bounds_met,
        "discrepancy_percent": 100.0 * found.size,
        "contact_mm": {name: [1e3 * x for x in pair] for name, pair in best.contact.items()},
        "error_fitted_percent": 100.0 * error_on(best, tests, kept),
        "folds": {name: fits.fold_errors(candidate, part) for name, part in parts.items()},
        "held_out": {name: _held_out_error(candidate, fits, part) for name, part in parts.items()},
    }  # fmt: skip
    return report, found.weighted, best


def _held_out_error(candidate: Candidate, fits: Fits, part: Sequence[Mask]) -> float | None:
    """Error on all that a part leaves out, None if that is nothing."""
    out = [~mask for mask in part]
    if not any(mask.any() for mask in out):
        return None
    return error_on(fits.of(candidate, part)[1], fits.tests, out)


def group_report(
    tests: Sequence[LawTest],
    candidates: Sequence[Candidate],
    folds: Mapping[str, Sequence[str]],
    tolerance: float,
    confidence: float,
    progress: Progress | None = None,
) -> tuple[dict[str, Any], pd.DataFrame]:
    """Every law on the tests of a group.

    Parameters
    ----------
    folds : mapping
        Samples that the study leaves out in turn, by name of the fold.
    tolerance : float
        Largest error of a response between runs, as a part of the peak.
    confidence : float
        Of the intervals.
    progress : callable, optional
        Told the law and the finished part.

    Returns
    -------
    report : dict
        `law_report` by law, each with `simpler`, laws of fewer parameters that the records do not
        reject beside it; `skipped`: why a law was left out, by law; `reached`: the part of its
        loading that was fitted, by sample whose runs go less far.
    curves : DataFrame
        `law`, `sample`, `displacement_mm`, `measured_N`, `model_N`.

    Raises
    ------
    CalibrationError
        If no law can be simulated.
    """
    parts, fits = parts_of(tests, folds), Fits(tests)
    laws: dict[str, Any] = {}
    skipped: dict[str, str] = {}
    likeliest: list[tuple[Problem, LawFit]] = []
    for done, candidate in enumerate(candidates):
        if progress is not None:
            progress(candidate.title, done / len(candidates))
        started = time.process_time()
        error = simulate_law(candidate, tests, tolerance, parts[ALL])
        if error is None:
            skipped[candidate.name] = "elements are crushed where it fits best"
            continue
        found, problem, best = law_report(candidate, fits, parts, confidence)
        cost = {"cpu_s": round(time.process_time() - started, 2)}
        laws[candidate.name] = {**found, "curve_error_percent": 100.0 * error, **cost}
        likeliest.append((problem, best))
    if not laws:
        raise CalibrationError(f"no elastic law could be simulated: {skipped}; add neo_hooke")
    every = [best for _, best in likeliest]
    for problem, best in likeliest:
        laws[best.candidate.name]["simpler"] = simpler_laws(problem, best, every, confidence)
    reached = {test.sample: test.reached for test in tests if test.reached < 1.0}
    report = {"laws": laws, "skipped": skipped, "reached": reached}
    return report, pd.concat(_curves(best, tests) for best in every)


def _curves(fit: LawFit, tests: Sequence[LawTest]) -> pd.DataFrame:
    """Records and a law's forces, in the signs of the study."""
    return pd.concat(
        pd.DataFrame(
            {
                "law": fit.candidate.name,
                "sample": test.sample,
                "displacement_mm": travel_sign(test.mode) * 1e3 * test.displacement,
                "measured_N": travel_sign(test.mode) * test.force,
                "model_N": travel_sign(test.mode) * fit.force(test),
            }
        )
        for test in tests
    )
