"""Groups that share their physics: what the others were measured to do is predicted of one.

Plugs of a foam between plates that slide, as in `test_foam`: nothing of the package predicts a
force. Of each group the loading up to a strain is known, and all of the others.
"""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import laboratory
from softsample.loop import pool
from softsample.loop.diagnose import diagnose
from softsample.loop.effects import library
from softsample.loop.effects.base import SOLID
from softsample.loop.errors import held_out_errors
from softsample.loop.pool import Group, Pooled, pooled
from softsample.loop.posed import LoopSettings, Posed
from softsample.loop.rounds import SelectionSettings
from softsample.loop.verdict import judgement
from softsample.shapes import IdealShape

PLUG = IdealShape("cylinder", 15e-3, 15e-3, 10e-3)
STRAIN, KNOWN = 0.45, 0.25
GROUPS = {  # modulus [Pa], exponent, part of the force that is missing on unloading
    "a": (2000.0, 5.0, 0.20),
    "b": (1200.0, 5.4, 0.22),
    "c": (2600.0, 4.7, 0.19),
    "d": (1700.0, 5.2, 0.21),
}
SETTINGS = LoopSettings()
NAMES = ("compressible_foam", "elastic_law", "unloading_loss", "force_drift", "permanent_set")


def cycle(name, seed):
    """One cycle of a group's plug; loading beyond a strain and unloading are held out."""
    test = laboratory.foam_cycle(name, PLUG, *GROUPS[name], STRAIN, step=0.4, seed=seed)
    beyond = test.travel > KNOWN * PLUG.height
    return replace(test, held_out=beyond | (test.phase == "unloading"))


def effects(test):
    known = library(SOLID, [test])
    return [known[name] for name in NAMES]


def own(test):
    """Verdict of a group by itself."""
    return judgement(diagnose([test], SETTINGS, effects(test)), SETTINGS)


def in_full(test):
    return replace(test, held_out=np.zeros(len(test.force), bool))


PART = [cycle(name, seed) for seed, name in enumerate(GROUPS)]
WHOLE = [in_full(test) for test in PART]


def group(whole, part, verdicts=(None, None)):
    """A group of which all records are known, and a part; its verdicts on both."""
    posed = [Posed.of([test], SETTINGS) for test in (whole, part)]
    return Group.of(posed, [effects(whole), effects(part)], verdicts, verdicts[1])


def groups(verdicts):
    return [group(*tests, found) for *tests, found in zip(WHOLE, PART, verdicts, strict=True)]


@pytest.fixture(scope="module")
def verdicts():
    """Of every group, on all of its records and by itself."""
    return [(own(whole), own(part)) for whole, part in zip(WHOLE, PART, strict=True)]


@pytest.fixture(scope="module")
def told(verdicts):
    """What the last three groups tell of the first."""
    first, *others = groups(verdicts)
    return pooled(first, others, SETTINGS.selection)


@pytest.fixture(scope="module")
def found(told):
    return diagnose(PART[:1], SETTINGS, effects(PART[0]), told)


def percent(errors):
    return 100.0 * max(error.rms / error.peak for error in errors.values())


def test_unloading_that_no_record_of_the_group_shows_is_told_by_the_others(found):
    assert found.verdict == "explained", found.objection
    assert set(found.selection.classes) == {"compressible_foam", "unloading_loss"}
    assert percent(found.before.held_out) > 10.0
    assert percent(found.selected.held_out) < 2.0
    alone = diagnose(PART[:1], SETTINGS, effects(PART[0]))
    assert "unloading_loss" not in alone.selection.classes
    assert percent(found.selected.held_out) < 0.5 * percent(alone.after.held_out)


def test_sizes_that_others_tell_have_intervals_as_wide_as_the_groups_scatter(found):
    verdict = judgement(found, SETTINGS)
    loss = next(e for e in verdict["effects"] if e["name"] == "unloading_loss")["parameters"][
        "loss"
    ]
    assert loss["low"] < GROUPS["a"][2] < loss["high"]
    told = [GROUPS[name][2] for name in list(GROUPS)[1:]]
    assert loss["high"] - loss["low"] > np.std(told)
    assert verdict["pooled"]["groups"] == 3
    assert verdict["pooled"]["others_after_percent"] < verdict["pooled"]["others_alone_percent"]


def test_forces_that_are_held_out_of_the_group_change_nothing(found, told, verdicts):
    test = PART[0]
    changed = replace(test, force=np.where(test.held_out, 3.0 * test.force, test.force))
    _, *others = groups(verdicts)
    again = pooled(group(in_full(changed), changed, verdicts[0]), others, SETTINGS.selection)
    assert again.document() == told.document()
    other = diagnose([changed], SETTINGS, effects(changed), again)
    assert other.final.state == found.final.state
    assert held_out_errors(other.final, [test], {}, {}) == held_out_errors(
        found.final, [test], {}, {}
    )


def test_what_a_group_is_told_does_not_depend_on_searches_for_others(told, verdicts):
    """Which share their fits; and the document tells all of it."""
    first, *others = zip(GROUPS, groups(verdicts), strict=True)
    progress = []
    documents = pool.documents(
        dict([*others, first]), SETTINGS.selection, lambda *at: progress.append(at)
    )
    assert progress == [("b", 0.0), ("c", 0.25), ("d", 0.5), ("a", 0.75)]
    assert documents["a"] == told.document()
    again = Pooled.of_document(json.loads(json.dumps(told.document())))
    one, two = (diagnose(PART[:1], SETTINGS, effects(PART[0]), of) for of in (told, again))
    assert one.final.state == two.final.state


def test_two_other_groups_are_too_few(verdicts):
    first, *others = groups(verdicts)
    assert pooled(first, others[:2], SETTINGS.selection) is None


def test_a_model_that_ended_in_another_minimum_is_fitted_from_the_values_of_others():
    """As after effects that were added in an unlucky order."""
    good, guide = (
        group(test, test).with_effect("compressible_foam", SETTINGS.selection.class_gain)
        for test in WHOLE[:2]
    )
    fit = good.whole
    far = replace(fit.state, values={"compressible_foam": {"alpha": -25.0, "nu": 0.45, "share": 1}})
    stuck = replace(good, whole=fit.problem.at(fit.model, far))
    again = stuck.refitted([guide]).whole.state
    for name in ("alpha", "nu"):
        own, found = (s.values["compressible_foam"][name] for s in (fit.state, again))
        assert found == pytest.approx(own, abs=0.02 * abs(own) + 0.01)
    assert good.refitted([]) is good
    off = np.exp(0.2 / np.linalg.norm(fit.jacobian[:, 0]))  # a fit ends so near to its minimum
    material = replace(fit.state.material, mu=off * fit.state.material.mu)
    near = replace(good, whole=fit.problem.at(fit.model, replace(fit.state, material=material)))
    assert near.refitted([guide]) is near


def test_an_effect_holds_in_a_group_unless_it_ends_at_a_bound_there():
    tie, effect = SETTINGS.selection.class_gain, "compressible_foam"
    tried = pool._Tried([group(test, test).with_effect(effect, tie) for test in WHOLE[1:3]])
    first = group(WHOLE[0], WHOLE[0])  # with an exponent of 5
    assert tried.holds_in(first)
    known = effects(WHOLE[0])
    narrow = [
        replace(p, high=3.0) if p.name == "alpha" else p
        for p in next(one for one in known if one.name == effect).parameters
    ]
    narrowed = [
        replace(one, parameters=tuple(narrow)) if one.name == effect else one for one in known
    ]
    assert not tried.holds_in(replace(first, shown={one.name: one for one in narrowed}))


SCATTER = np.array([-0.02, 0.0, 0.02])


class Tried:
    """Groups of which errors and evidence of all sets of effects are given."""

    usable = True

    def __init__(self, names, left, evidence, holds):
        self.names, self.all = names, (left, evidence, holds)
        self.left = left[frozenset(names)]
        self.mean = self.left.mean()

    def with_effect(self, name, tie):
        return Tried([*self.names, name], *self.all)

    def more_likely(self, before):
        (added,) = set(self.names) - set(before.names)
        return self.all[1][added]

    def holds_in(self, own):
        return self.all[2](self.names)


def searched(monkeypatch, left, evidence, holds=lambda names: True, laws=""):
    """What a search finds where errors and evidence of all sets of three effects are given."""
    own = SimpleNamespace(shown={n: SimpleNamespace(is_law=n in laws) for n in "abc"})
    errors = {frozenset(names): error + SCATTER for names, error in left.items()}
    # groups scatter so much with "a" that no third effect is significantly better
    errors[frozenset("a")] = 1.0 + 10.0 * SCATTER
    monkeypatch.setattr(
        pool._Search, "_open", lambda self, chosen: [n for n in "abc" if n not in chosen]
    )
    start = Tried([], errors, evidence, holds)
    rules = replace(SelectionSettings(), most_effects=2)
    return pool._Search(own, (), rules).completed(pool._Chain(start))


def test_effects_that_were_tried_in_another_order_are_not_fitted_again(monkeypatch):
    left = {"": 3.0, "a": 1.0, "b": 1.01, "c": 2.0, "ab": 0.2, "ac": 0.99, "bc": 0.9}
    tried = []
    monkeypatch.setattr(Tried, "__init__", recorded(Tried.__init__, tried))
    searched(monkeypatch, left, dict.fromkeys("abc", 100.0))
    assert len(tried) == len(set(tried)) == 7


def recorded(method, tried):
    def given(self, names, *others):
        tried.append(frozenset(names))
        method(self, names, *others)

    return given


def test_of_two_effects_as_good_as_each_other_both_are_followed(monkeypatch):
    """The better one at first leads nowhere; beside the other a third lowers the error."""
    left = {"": 3.0, "a": 1.0, "b": 1.01, "c": 2.0, "ab": 0.99, "ac": 0.99, "bc": 0.2}
    found = searched(monkeypatch, left, dict.fromkeys("abc", 100.0))
    assert found.classes == {"b": ["b", "a"], "c": ["c"]}
    assert found.evidence == {"b": 100.0, "c": 100.0}


@pytest.mark.parametrize(("evidence", "expected"), [(150.0, "cb"), (50.0, "a")])
def test_the_effect_that_all_records_ask_for_most_is_followed_too(monkeypatch, evidence, expected):
    """Alone it lowers the error less than two others; beside it a third does."""
    left = {"": 3.0, "a": 1.0, "b": 2.0, "c": 2.0, "ab": 0.99, "ac": 0.99, "bc": 0.2}
    found = searched(monkeypatch, left, {"a": 100.0, "b": 100.0, "c": evidence})
    assert "".join(found.classes) == expected


@pytest.mark.parametrize(("laws", "expected"), [("ab", "bc"), ("b", "a"), ("a", "a")])
def test_beside_a_law_the_best_other_law_is_followed_too(monkeypatch, laws, expected):
    """It alone lowers the error far less; with an effect of the machine it is the right one."""
    left = {"": 3.0, "a": 1.0, "b": 2.0, "c": 2.5, "ab": 0.99, "ac": 0.99, "bc": 0.2}
    evidence = {"a": 100.0, "b": 90.0, "c": 50.0}
    assert "".join(searched(monkeypatch, left, evidence, laws=laws).classes) == expected


def test_an_effect_that_ends_at_a_bound_in_the_group_is_none_of_its(monkeypatch):
    left = {"": 3.0, "a": 1.0, "b": 1.01, "c": 2.0, "ab": 0.99, "ac": 0.99, "bc": 0.2}
    evidence = dict.fromkeys("abc", 100.0)
    found = searched(monkeypatch, left, evidence, holds=lambda names: "b" not in names)
    assert list(found.classes) == ["a"]
