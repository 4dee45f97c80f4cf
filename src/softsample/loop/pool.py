"""What the other groups of a study tell of one: effects, and how large they are.

Groups of a study share their physics: each has a material of its own, and parameters of effects
vary about a common mean. All that was measured of the other groups is known. Effects are added one
by one, each time the one with which the others would have been predicted best: every one of them
in its turn, from what is not held out of it and from all of the rest.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from softsample.holdout import FEWEST_OTHERS
from softsample.loop.discrepancy import settled
from softsample.loop.effects.base import Effect, Parameter, Values
from softsample.loop.errors import held_out_errors
from softsample.loop.fit import SETTLED, Fit
from softsample.loop.joint import joint_fit, law_fit
from softsample.loop.model import FIXED, Model, State
from softsample.loop.posed import Posed
from softsample.loop.rounds import SelectionSettings
from softsample.loop.scale import most_likely
from softsample.loop.screen import best_of_each, signatures
from softsample.loop.specimen import Array, Specimen
from softsample.loop.usable import misfit_with_penalties, unusable

MOST_UNUSABLE = 0.5
"""Part of the groups in which effects may explain nothing; in more of them they are none."""

BRANCHES = 2
"""Effects of those that are equally good that a search follows."""

GUESSES = 2
"""Values of other groups, the likeliest, from which a group is fitted again."""

BETTER = 10.0 * SETTLED
"""Fall of the sum of squares from which on a fit is another one: two fits that ended after steps of
`SETTLED` may lie so far apart."""

Told = Mapping[str, Mapping[str, tuple[float, float]]]
"""Mean and standard deviation of parameters, by effect and parameter."""

Library = Mapping[str, Effect]
"""Effects by name."""


@dataclass(frozen=True, eq=False)
class Group:
    """A group, all that was measured of it and what is not held out.

    Fits of it are remembered: searches for the effects of the other groups ask for the same ones.

    Parameters
    ----------
    whole : Fit
        Plain model of all records, or one with effects.
    part : Fit
        Plain model of what is not held out.
    tests : sequence of Specimen
        All tests, with what is held out of them marked.
    library, shown : mapping of Effect
        Effects that all of its records may show, and what is not held out.
    asked, asked_alone : collection of str
        Effects that those have asked for, and these.
    alone : float
        Logarithm of the error on what is held out, by its own diagnosis; NaN if nothing is.
    """

    whole: Fit
    part: Fit
    tests: Sequence[Specimen]
    library: Library
    shown: Library
    asked: Collection[str] = ()
    asked_alone: Collection[str] = ()
    alone: float = np.nan
    _more: dict[str, Self] = field(default_factory=dict, init=False, repr=False)
    _guesses: "dict[Group, _Guess]" = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def of(
        cls,
        posed: Sequence[Posed],
        effects: Sequence[Sequence[Effect]],
        verdicts: Sequence[Mapping[str, Any] | None] = (None, None),
        alone: Mapping[str, Any] | None = None,
    ) -> Self:
        """From the records of a group, all of them and what is not held out.

        `verdicts` are what diagnoses of both found with these ends, `alone` is the `verdict.json`
        of the latter.
        """
        whole, part = posed
        every, shown = ({effect.name: effect for effect in of} for of in effects)
        asked, asked_alone = map(_asked, verdicts)
        errors = [
            0.01 * test["rms_percent"]
            for test in (alone or {}).get("held_out_after", {}).get("held_out", {}).values()
        ]
        return cls(
            whole.plain,
            part.plain,
            part.specimens,
            every,
            shown,
            asked,
            asked_alone,
            _log_rms(errors),
        )

    def with_effect(self, name: str, tie: float) -> Self:
        """The same with one effect more in the model of all records."""
        if name not in self._more:
            fit, effect = self.whole, self.library[name]
            if effect.is_law:
                found = law_fit(fit, effect, tie)
            else:
                signature = best_of_each(signatures(fit, [effect]), fit.white)[name][1]
                found = joint_fit(fit, signature, tie)
            self._more[name] = replace(self, whole=settled(fit.problem, found))
        return self._more[name]

    def refitted(self, others: Sequence["Group"]) -> "Group":
        """The same, its model of all records fitted from the likeliest values of others too.

        What the first fit finds depends on the order in which effects were added.
        """
        guesses = sorted(map(self._guess, others), key=lambda guess: guess.left)[:GUESSES]
        best = min(guesses, key=lambda guess: guess.fit.cost, default=None)
        return best.group if best and best.fit.cost < self.whole.cost - BETTER else self

    def _guess(self, other: "Group") -> "_Guess":
        """What another group tells a fit of this one."""
        return self._guesses.setdefault(other, _Guess(self, other))

    @cached_property
    def told(self) -> Told:
        """Parameters of the effects in the model of all records, with standard deviations."""
        fit = self.whole
        deviations = iter(np.sqrt(np.diag(fit.covariance))[FIXED:])
        return {
            effect.name: {
                p.name: (fit.state.values[effect.name][p.name], next(deviations) * (p.high - p.low))
                for p in effect.parameters
            }
            for effect in fit.model.effects
        }

    def error(self, fit: Fit) -> float:
        """Logarithm of the error of a fit on what is held out [parts of peaks, RMS over tests]."""
        found = held_out_errors(fit, self.tests, {}, most_likely(fit))
        return _log_rms([e.rms / e.peak for e in found.values()])


@dataclass(frozen=True, eq=False)
class _Guess:
    """Values that another group has for the effects of one, as the initial guess of a fit."""

    own: Group
    other: Group

    @cached_property
    def start(self) -> State:
        """The state, with the modulus of the group itself."""
        fit = self.own.whole
        there = replace(fit.state, values=self.other.whole.state.values)
        return fit.problem.of_own_modulus(fit.model, there)

    @cached_property
    def left(self) -> float:
        """What is left there: sum of squares."""
        fit = self.own.whole
        return float(np.sum(fit.problem.residual(fit.model, self.start) ** 2))

    @cached_property
    def fit(self) -> Fit:
        """The fit from there."""
        fit = self.own.whole
        return fit.problem.fits(fit.model, [self.start], found=[fit])[-1]

    @cached_property
    def group(self) -> Group:
        """The group with that fit."""
        return replace(self.own, whole=settled(self.fit.problem, self.fit))


def predicted(
    part: Fit, library: Library, told: Told, guesses: Sequence[Mapping[str, Values]] = ()
) -> Fit:
    """Records fitted with effects of which others tell the parameters.

    Parameters
    ----------
    part : Fit
        Plain model of these records.
    library : mapping of Effect
        Effects that they may show.
    told : mapping
        Of the effects.
    guesses : sequence of mapping
        Values of other groups, from which the fit sets out too.
    """
    effects = [_known(library[name], of) for name, of in told.items()]
    means: dict[str, Values] = {
        e.name: {p.name: p.known[0] for p in e.parameters if p.known} for e in effects
    }
    start, *others = (State(part.state.material, values) for values in (means, *guesses))
    return settled(part.problem, part.problem.fit(Model(tuple(effects)), start, others))


def _asked(verdict: Mapping[str, Any] | None) -> set[str]:
    """Effects that passed the threshold in a round of a diagnosis."""
    return {
        candidate["name"]
        for step in (verdict["path"] if verdict else [])
        for candidate in step["candidates"]
        if candidate["evidence"] >= step["threshold"]
    }


def _log_rms(errors: Sequence[float]) -> float:
    """Logarithm of the root mean square; NaN of none."""
    return float(0.5 * np.log(np.mean(np.square(errors)))) if len(errors) else np.nan


@dataclass(frozen=True)
class Pooled:
    """Effects of a group that the others have chosen.

    Parameters
    ----------
    told : mapping
        Of the effects, in the order in which they were added.
    guesses : list of mapping
        Values of each of the other groups.
    classes : dict of list of str
        Names that are as good as each effect, itself first.
    evidence : dict of float
        What each effect made likelier in all records of the others, as in the selection.
    before, alone : float
        Error on what is held out of the others [% of peak, geometric mean]: of the plain model, and
        of the diagnosis of each by itself.
    left : (groups,) float64
        Logarithm of that with these effects, of each.
    """

    told: Told
    guesses: Sequence[Mapping[str, Values]]
    classes: dict[str, list[str]]
    evidence: dict[str, float]
    before: float
    alone: float
    left: Array

    def document(self) -> dict[str, Any]:
        """As JSON, for `of_document`."""
        left = [None if np.isnan(error) else float(error) for error in self.left]
        return {**vars(self), "left": left}

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """What `document` wrote."""
        return cls(**{**document, "left": np.array(document["left"], float)})

    def report(self) -> dict[str, float]:
        """What `verdict.json` holds."""
        return {
            "groups": len(self.left),
            "others_before_percent": self.before,
            "others_alone_percent": self.alone,
            "others_after_percent": _percent(self.left),
        }


def documents(
    groups: Mapping[str, Group],
    rules: SelectionSettings,
    progress: Callable[[str, float], None] | None = None,
) -> dict[str, dict[str, Any] | None]:
    """What the others have chosen for each group, as JSON, see `pooled`; None if nothing.

    Parameters
    ----------
    groups : mapping
        The groups by name.
    rules : SelectionSettings
        As of the selection in one group.
    progress : callable, optional
        Told the group and the finished part.
    """
    found = {}
    for done, (name, own) in enumerate(groups.items()):
        if progress is not None:
            progress(name, done / len(groups))
        told = pooled(own, [one for one in groups.values() if one is not own], rules)
        found[name] = told.document() if told else None
    return found


def pooled(own: Group, others: Sequence[Group], rules: SelectionSettings) -> Pooled | None:
    """Effects that predict the other groups better than their own diagnoses, if there are any.

    An effect is added if all records of the others ask for it, it lowers the error on what is
    held out of them by more than one standard error of the mean over them, and it does not end at
    a bound in the group itself.

    Parameters
    ----------
    own : Group
        What is to be predicted: nothing that is held out of it is used.
    rules : SelectionSettings
        As of the selection in one group.
    """
    if len(others) < FEWEST_OTHERS:
        return None
    plain, alone = _Tried(others), np.array([group.alone for group in others])
    found = _Search(own, others, rules).completed(_Chain(plain))
    tried, left = found.tried, found.tried.left
    if not found.classes or np.nanmean(left) >= np.nanmean(alone):
        return None
    return Pooled(
        tried.common,
        tried.values,
        found.classes,
        found.evidence,
        _percent(plain.left),
        _percent(alone),
        left,
    )


def _percent(errors: Array) -> float:
    """Geometric mean of errors from their logarithms [%]."""
    return float(100.0 * np.exp(np.nanmean(errors)))


@dataclass(frozen=True, eq=False)
class _Tried:
    """The other groups with the same effects in the models of all of their records."""

    groups: Sequence[Group]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the effects."""
        return self.groups[0].whole.model.names

    @property
    def common(self) -> Told:
        """What all of them tell."""
        return _common([group.told for group in self.groups])

    @property
    def values(self) -> list[Mapping[str, Values]]:
        """Values of each."""
        return [group.whole.state.values for group in self.groups]

    @cached_property
    def left(self) -> Array:
        """Logarithm of the error on what is held out of each, effects predicted from the others."""
        if not self.names:
            return np.array([group.error(group.part) for group in self.groups])
        told = [group.told for group in self.groups]
        return np.array([
            group.error(predicted(group.part, group.shown, _common([*told[:k], *told[k + 1 :]])))
            for k, group in enumerate(self.groups)
        ])  # fmt: skip

    @property
    def mean(self) -> float:
        """Of the logarithms of the errors."""
        return float(np.nanmean(self.left))

    @property
    def usable(self) -> bool:
        """Whether the effects may explain something in most of them."""
        none = sum(bool(unusable(group.whole)) for group in self.groups)
        return none <= MOST_UNUSABLE * len(self.groups)

    def holds_in(self, own: Group) -> bool:
        """Whether the effects may explain something in another group, too."""
        return not unusable(predicted(own.part, own.shown, self.common, self.values))

    def with_effect(self, name: str, tie: float) -> Self:
        """The same with one effect more."""
        alone = [group.with_effect(name, tie) for group in self.groups]
        groups = [g.refitted([*alone[:k], *alone[k + 1 :]]) for k, g in enumerate(alone)]
        return replace(self, groups=groups)

    def more_likely(self, before: Self) -> float:
        """Fall of twice the negative log likelihood of all records, less the penalties."""
        pairs = zip(before.groups, self.groups, strict=True)
        return sum(
            misfit_with_penalties(one.whole) - misfit_with_penalties(more.whole)
            for one, more in pairs
        )


@dataclass(frozen=True)
class _Chain:
    """Effects that were added one after the other.

    Parameters
    ----------
    tried : _Tried
        The other groups with these effects.
    classes, evidence : dict
        As those of `Pooled`.
    """

    tried: _Tried
    classes: dict[str, list[str]] = field(default_factory=dict)
    evidence: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class _Search:
    """For effects of a group in the others; the first three parameters are those of `pooled`.

    Parameters
    ----------
    known : dict
        Sets of effects that were tried.
    """

    own: Group
    others: Sequence[Group]
    rules: SelectionSettings
    known: dict[frozenset[str], _Tried] = field(default_factory=dict)

    def completed(self, chain: _Chain) -> _Chain:
        """The chain with more effects, as long as they lower the error.

        Of effects that do so equally well the best two are followed to their ends: what is second
        now can be what another effect needs beside it. So are the one that all records ask for
        most, as what is held out is a small part of them, and the best other law: a wrong one may
        stand for the right one and an effect of the machine.
        """
        if len(chain.classes) == self.rules.most_effects:
            return chain
        open_to_all = self._open(chain.classes)
        found = {name: more for name in open_to_all if (more := self._added(chain, name))}
        left = {name: more.tried.left for name, more in found.items()}
        ranked = sorted(found, key=lambda name: found[name].tried.mean)
        if not ranked or not lower(left[ranked[0]], chain.tried.left):
            return chain
        alike = [name for name in ranked if not lower(left[ranked[0]], left[name])]
        likeliest = max(found, key=lambda name: found[name].evidence[name])
        followed = [*alike[:BRANCHES], likeliest]
        laws = [name for name in ranked if self.own.shown[name].is_law]
        if not set(laws).isdisjoint(followed):
            followed += [name for name in laws if name not in followed][:1]
        ends = []
        for name in dict.fromkeys(followed):
            classes = {**chain.classes, name: [name, *(n for n in alike if n != name)]}
            if lower(left[name], chain.tried.left):
                ends.append(self.completed(replace(found[name], classes=classes)))
        return min(ends, key=lambda end: end.tried.mean)

    def _added(self, chain: _Chain, name: str) -> _Chain | None:
        """The chain with one effect more; None if it is asked for too little, or cannot be."""
        names = frozenset([*chain.classes, name])
        if names not in self.known:
            self.known[names] = chain.tried.with_effect(name, self.rules.class_gain)
        tried = self.known[names]
        size = tried.more_likely(chain.tried)
        if size < self.rules.least_gain or not tried.usable or not tried.holds_in(self.own):
            return None
        return replace(chain, tried=tried, evidence={**chain.evidence, name: size})

    def _open(self, chosen: Collection[str]) -> list[str]:
        """Effects that may be added: asked for by some group, open to all, one law among them."""
        asked = set(self.own.asked_alone).union(*(group.asked for group in self.others))
        model = Model(tuple(self.own.shown[name] for name in chosen))
        return [
            name
            for name, effect in self.own.shown.items()
            if name in asked
            and model.admits(effect)
            and all(
                _alike(effect, library.get(name))
                for group in self.others
                for library in (group.library, group.shown)
            )
        ]


def _alike(one: Effect, other: Effect | None) -> bool:
    """Whether an effect has the same parameters in two groups: fibres need not."""
    names = [p.name for p in one.parameters]
    return other is not None and [p.name for p in other.parameters] == names


def lower(one: Array, other: Array) -> bool:
    """Whether errors are lower on the whole, by more than one standard error."""
    apart = (one - other)[np.isfinite(one - other)]
    if len(apart) < FEWEST_OTHERS:
        return False
    return bool(apart.mean() + np.std(apart, ddof=1) / np.sqrt(len(apart)) < 0.0)


def _common(told: Sequence[Told]) -> Told:
    """What groups tell of another one: their mean, and how far that one may be from it."""
    return {
        effect: {name: _spread([one[effect][name] for one in told]) for name in parameters}
        for effect, parameters in told[0].items()
    }  # fmt: skip


def _spread(told: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Mean of values with standard deviations, and the standard deviation of a further one."""
    values, deviations = np.array(told).T
    between = np.var(values, ddof=1) * (1.0 + 1.0 / len(values))
    return float(values.mean()), float(np.sqrt(between + np.mean(deviations**2)))


def _known(effect: Effect, told: Mapping[str, tuple[float, float]]) -> Effect:
    """An effect with priors of its parameters, their means within the ranges."""

    def known(p: Parameter) -> Parameter:
        mean, deviation = told[p.name]
        return replace(p, known=(float(np.clip(mean, p.low, p.high)), deviation))

    return replace(effect, parameters=tuple(known(p) for p in effect.parameters))
