"""Frozen answers against what was planted: goals with bounds, confusion of effects."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import beta, binom

from softsample.blindlab.bodies import POISSON
from softsample.blindlab.faults import EFFECTS
from softsample.errors import InputError

Row = dict[str, Any]

POWER = 0.95
"""Share of experiments in which an effect has to be noticed to count as identifiable."""

VERDICTS = ("explained_class", "unknown", "none")
"""Answers that name no effect."""

FOLDS = ("leave_out", "after_ramp", "last_quarter")
"""Kinds of folds."""

NEUTRAL = {"nu": POISSON}
"""Where a size means no effect at all, if that is not zero."""

SHAPES = ("tau_s", "period_s")
"""True values that say how an effect acts, not how large it is."""

LEAST_ERROR = 0.1
"""Structured errors below this [% of peak] are none that could be removed."""

LEAST_BIAS = 0.01
"""Moduli that are less wrong than this have no bias to remove."""


@dataclass(frozen=True)
class Case:
    """An experiment with its answer.

    Parameters
    ----------
    planted : mapping
        As of `Experiment.planted`.
    answer : mapping
        As of `judge.answer`.
    """

    planted: Mapping[str, Any]
    answer: Mapping[str, Any]

    @property
    def names(self) -> list[str]:
        """What was planted."""
        return list(self.planted["names"])

    @property
    def noticed(self) -> bool:
        """Whether the answer says that something is wrong."""
        return bool(self.answer["verdict"] != "none")

    @property
    def named(self) -> bool:
        """Whether the answer commits itself to effects."""
        return bool(self.answer["verdict"] == "explained")

    @property
    def classes(self) -> list[list[str]]:
        """Classes of the answer, none if it does not commit itself."""
        return [effect["class"] for effect in self.answer["effects"]] if self.named else []

    @property
    def found(self) -> int:
        """How many of the planted effects lie in a class of the answer."""
        return sum(any(name in names for names in self.classes) for name in self.names)

    @property
    def extra(self) -> bool:
        """Whether a class of the answer holds nothing that was planted."""
        return any(not set(names) & set(self.names) for names in self.classes)

    @property
    def first(self) -> str:
        """First effect of the answer, or its verdict."""
        return str(self.answer["effects"][0]["name"]) if self.named else self.answer["verdict"]

    @property
    def bias(self) -> tuple[float, float]:
        """Relative error of the modulus before and after."""
        before, after = (
            self.answer[f"theta_{when}"]["mu"]["value"] / self.planted["mu_pa"] - 1.0
            for when in ("before", "after")
        )
        return abs(before), abs(after)

    def held_out_removed(
        self, folds: str = "", left: Mapping[str, float] | None = None
    ) -> list[float]:
        """Part of the structured error on what each fold leaves out that the answer removes.

        Of folds whose names begin with `folds`, where there is an error to be removed. `left` says
        by fold what is left [% of peak] instead of the answer's error.
        """
        return [
            1.0 - (error["after"] if left is None else left[fold]) / error["before"]
            for fold, error in self.answer["held_out_percent"].items()
            if fold.startswith(folds) and error["before"] > LEAST_ERROR
        ]


def opened(
    planted: Mapping[str, Any], seal: Mapping[str, Any], sha256: str
) -> list[Mapping[str, Any]]:
    """What was planted in each experiment, if it is what was sealed.

    Raises
    ------
    InputError
        If the file has changed since, by its `sha256`.
    """
    if sha256 != seal["sha256"]:
        raise InputError(
            f"the truth has SHA-256 {sha256[:12]}..., withheld was {seal['sha256'][:12]}...: "
            "delete seal and answers and judge again"
        )
    return list(planted["experiments"])


def nothing(goal: str) -> Row:
    """A goal that no experiment speaks of."""
    return {"goal": goal, "value": None, "bound": None, "n": 0}


def share(goal: str, hits: Sequence[bool], side: str) -> Row:
    """A share with its one-sided 95 % bound (Clopper and Pearson), upper or lower."""
    n, k = len(hits), int(np.sum(hits))
    if not n:
        return nothing(goal)
    upper, lower = beta.ppf(0.95, k + 1, n - k), beta.ppf(0.05, k, n - k + 1)
    bound = (1.0 if k == n else upper) if side == "upper" else (0.0 if k == 0 else lower)
    return {"goal": goal, "value": k / n, "bound": float(bound), "n": n}


def median(goal: str, values: Sequence[float], side: str) -> Row:
    """A median with its one-sided 95 % bound from order statistics."""
    ordered, n = np.sort(np.asarray(values, dtype=float)), len(values)
    if not n:
        return nothing(goal)
    rank = int(binom.ppf(0.05, n, 0.5))
    bound = ordered[max(rank - 1, 0)] if side == "lower" else ordered[min(n - rank, n - 1)]
    return {"goal": goal, "value": float(np.median(ordered)), "bound": float(bound), "n": n}


def score(cases: Sequence[Case]) -> list[Row]:
    """All goals for each design, floor and size: goal, design, floor, size, value, bound, n.

    Bounds are one-sided at 95 %, on the side where the goal would be missed; counts of effects
    have none.
    """
    rows = []
    settings = _by(cases, lambda case: (case.planted["design"], case.planted["floor_percent"]))
    for (design, floor), group in settings.items():
        setting = {"design": design, "floor_percent": floor}
        rows += [{**row, **setting, "size": None} for row in _overall(group)]
        singles = [case for case in group if case.planted["kind"] == "effect"]
        left = _left_undisturbed(group)
        for size, of_size in _by(singles, lambda case: case.planted["size"]).items():
            rows += [{**row, **setting, "size": size} for row in _effects(of_size, left)]
    return rows


def _left_undisturbed(cases: Sequence[Case]) -> dict[str, float]:
    """Held-out error of the plain model on records without effect: floor and noise, by fold."""
    nulls = [c.answer["held_out_percent"] for c in cases if c.planted["kind"] == "null"]
    folds = sorted({fold for errors in nulls for fold in errors})
    return {
        fold: float(np.median([errors[fold]["before"] for errors in nulls if fold in errors]))
        for fold in folds
    }


def _by(cases: Sequence[Case], key: Callable[[Case], Any]) -> dict[Any, list[Case]]:
    groups: dict[Any, list[Case]] = {}
    for case in cases:
        groups.setdefault(key(case), []).append(case)
    return dict(sorted(groups.items()))


def _by_names(cases: Sequence[Case]) -> dict[str, list[Case]]:
    return _by(cases, lambda case: " and ".join(case.names))


def _overall(cases: Sequence[Case]) -> Iterator[Row]:
    """Goals that need no effect at one size: nulls, scales, out-of-library effects, pairs, cost."""
    kinds = _by(cases, lambda case: case.planted["kind"])
    yield share("1 false alarms", [c.noticed for c in kinds.get("null", [])], "upper")
    scales = kinds.get("scale", [])
    yield share("scale not called identifiable", [not c.named for c in scales], "lower")
    out_of_library = kinds.get("stranger", [])
    yield share("6 out of library: unknown or none", [not c.named for c in out_of_library], "lower")
    for names, of_kind in _by_names(out_of_library).items():
        yield share(f"6 {names}", [not c.named for c in of_kind], "lower")
    pairs = kinds.get("pair", [])
    yield share("8 pairs: both classes", [c.found == 2 for c in pairs], "lower")
    yield share("8 pairs: at least one", [c.found >= 1 for c in pairs], "lower")
    known = _strong([c for c in kinds.get("effect", []) if c.planted["size"] == 1.0])
    able = [c for c in pairs if set(c.names) <= known]
    yield share(
        "8 pairs of effects with power: both classes", [c.found == 2 for c in able], "lower"
    )
    yield share("8 pairs: wrong extra", [c.extra for c in pairs], "upper")
    yield _calibration(cases)
    yield median("17 CPU seconds a verdict", [c.answer["cpu_s"] for c in cases], "upper")


def _calibration(cases: Sequence[Case]) -> Row:
    """Stated confidence in the first class less how often that is right, in the mean."""
    asked = [c for c in cases if c.named and c.answer.get("confidence") is not None]
    off = [c.answer["confidence"] - bool(set(c.classes[0]) & set(c.names)) for c in asked]
    goal = "16 stated confidence less hits"
    if not off:
        return nothing(goal)
    return {"goal": goal, "value": abs(float(np.mean(off))), "bound": None, "n": len(off)}


def _strong(cases: Sequence[Case]) -> set[str]:
    """Effects that are noticed nearly always."""
    return {
        names
        for names, of_name in _by_names(cases).items()
        if np.mean([c.noticed for c in of_name]) >= POWER
    }


def _effects(cases: Sequence[Case], left: Mapping[str, float]) -> Iterator[Row]:
    """Goals on single effects of one size; `left` is what undisturbed records leave, by fold."""
    effects = _by_names(cases)
    for names, of_name in effects.items():
        yield share(f"2 power {names}", [c.noticed for c in of_name], "lower")
    strong = _strong(cases)
    yield {"goal": "2 effects with power", "value": len(strong), "bound": None, "n": len(effects)}
    noticed = [c for c in cases if c.noticed]
    right = [c for c in noticed if c.found]
    yield share("3 class correct when noticed", [c.found == 1 for c in noticed], "lower")
    yield share("4 exact effect first", [c.first == c.names[0] for c in noticed], "lower")
    yield share("5 confidently wrong", [c.named and not c.found for c in cases], "upper")
    for names, of_name in effects.items():
        yield share(f"5 wrong {names}", [c.named and not c.found for c in of_name], "upper")
    yield share("wrong extra class", [c.extra for c in noticed], "upper")
    yield share("7 called unknown", [c.answer["verdict"] == "unknown" for c in cases], "upper")
    yield median("members of a class", [float(len(c.classes[0])) for c in right], "upper")
    removed = [np.median(c.held_out_removed()) for c in right if c.held_out_removed()]
    yield median("9 held-out error removed", removed, "lower")
    if left:
        at_most = [np.median(c.held_out_removed("", left)) for c in right if c.held_out_removed()]
        yield median("9 if undisturbed records' error were left", at_most, "upper")
    for kind in FOLDS:
        parts = [part for c in right for part in c.held_out_removed(kind)]
        yield median(f"9 of {kind}", parts, "lower")
    yield share("10 held-out worse by 5 %", [bool(part < -0.05) for part in removed], "upper")
    yield median("11 white RMS after", [
        float(np.sqrt(c.answer["reduced_chi_square"]["after"])) for c in right
    ], "upper")  # fmt: skip
    biased = [c.bias for c in cases if c.names[0] in strong and c.bias[0] > LEAST_BIAS]
    yield median("12 bias of mu removed", [1.0 - now / was for was, now in biased], "lower")
    yield share("13 cover of mu", [_covers(c.answer["theta_after"]["mu"], c.planted["mu_pa"])
                                   for c in right], "lower")  # fmt: skip
    recommended = [_covers(c.answer["recommended"], c.planted["mu_pa"]) for c in cases]
    yield share("13 cover of recommended mu", recommended, "lower")
    yield share("13 cover of effects", [hit for c in right for hit in _covered(c)], "lower")
    yield median("14 error of the size", [e for c in right for e in _size_errors(c)], "upper")


def _covers(interval: Mapping[str, float], value: float) -> bool:
    return bool(interval["low"] <= value <= interval["high"])


def _compared(case: Case) -> Iterator[tuple[str, Mapping[str, float], float]]:
    """Parameters of the named effect that mean the same as what was planted, with that."""
    for effect in case.answer["effects"]:
        sizes = case.planted["sizes"].get(effect["name"], {})
        for name, value in sizes.items():
            if name in effect["parameters"]:
                yield name, effect["parameters"][name], value


def _covered(case: Case) -> list[bool]:
    return [_covers(parameter, value) for _, parameter, value in _compared(case)]


def _size_errors(case: Case) -> list[float]:
    """Errors of what an effect grows with, as parts of what was planted beyond nothing."""
    return [
        abs((parameter["value"] - value) / (value - NEUTRAL.get(name, 0.0)))
        for name, parameter, value in _compared(case)
        if name not in SHAPES
    ]


def confusion(cases: Sequence[Case]) -> pd.DataFrame:
    """Share of answers (columns: first effect, or the verdict) for what was planted (rows).

    An answer whose first class holds what was planted counts for that, whichever member of the
    class stands first.
    """
    kept = [c for c in cases if c.planted["kind"] != "pair" and c.planted["size"] == 1.0]
    rows = [
        {"floor_percent": c.planted["floor_percent"], "design": c.planted["design"],
         "planted": " and ".join(c.names) or "nothing", "answered": _counted(c)}
        for c in kept
    ]  # fmt: skip
    table = pd.DataFrame(rows, columns=["floor_percent", "design", "planted", "answered"])
    shares = pd.crosstab(
        [table["design"], table["floor_percent"], table["planted"]],
        table["answered"],
        normalize="index",
    )
    others = sorted({*shares.columns} - {*EFFECTS, *VERDICTS})  # effects that are never planted
    return shares.reindex(columns=[*EFFECTS, *others, *VERDICTS], fill_value=0.0).reset_index()


def _counted(case: Case) -> str:
    """What an answer counts for."""
    if case.named and case.names and case.names[0] in case.classes[0]:
        return case.names[0]
    return case.first
