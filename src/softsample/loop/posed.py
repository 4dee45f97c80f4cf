"""Records of a group as a problem: noise, discrepancy, and specimens that differ in stiffness."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from softsample.loop.contact import own_contact
from softsample.loop.effects import specimen_stiffness
from softsample.loop.effects.base import Effect
from softsample.loop.fit import Fit, Problem
from softsample.loop.noise import (
    Noise,
    NoiseSettings,
    Whitener,
    block_size,
    covariances,
    measure_noise,
    memory,
    most_blocks,
    shared,
)
from softsample.loop.rounds import SelectionSettings
from softsample.loop.same_piece import in_common
from softsample.loop.scale import relative_stiffness, scatter
from softsample.loop.select import plain_model
from softsample.loop.specimen import Array, Specimen, blocks

STIFFNESS = specimen_stiffness.EFFECT.name
"""Effect that stands for what scattered specimens differ in."""

PER_BLOCK = 4
"""Points of a block at which predictions are computed."""


@dataclass(frozen=True)
class LoopSettings:
    """Mirrors config `loop:`.

    Parameters
    ----------
    noise, selection
        Sizes of noise and discrepancy; rules of the selection.
    absent : tuple of str
        Effects that the laboratory knows not to be there: they are no candidates.
    """

    noise: NoiseSettings = field(default_factory=NoiseSettings)
    selection: SelectionSettings = field(default_factory=SelectionSettings)
    absent: tuple[str, ...] = ()

    @classmethod
    def of_config(cls, loop: Mapping[str, Any]) -> Self:
        """From the config's section `loop`."""
        noise, selection = NoiseSettings(**loop["noise"]), SelectionSettings(**loop["selection"])
        return cls(noise, selection, tuple(loop["absent"]))


@dataclass(frozen=True)
class Posed:
    """The tests of a group, ready for models to be fitted.

    Parameters
    ----------
    specimens : list of Specimen
        All tests, with what is their specimens' own where these scatter.
    problem : Problem
        What is not held out of them.
    noises : list of Noise
        One for each test of the problem.
    first : Fit
        Plain model of one stiffness, with the contact points of specimens.
    stiffness : mapping of float
        Modulus of specimens over that of the group where they scatter; empty if not.
    contact : mapping of float
        Displacement at which the compression of specimens begins, over the mean [mm]; empty where
        the records do not ask for it.
    """

    specimens: list[Specimen]
    problem: Problem
    noises: list[Noise]
    first: Fit
    stiffness: Mapping[str, float]
    contact: Mapping[str, float]

    @classmethod
    def of(cls, specimens: Sequence[Specimen], settings: LoopSettings) -> Self:
        """Of tests that share their material and machine."""
        problem, noises = pose(specimens, settings.noise)
        first = plain_model(problem)
        usual = 0.01 * settings.noise.scale_percent * settings.selection.unknown_ratio
        contact = own_contact(first, usual, settings.selection.least_gain)
        if contact:
            specimens = [specimen.with_own(contact=contact) for specimen in specimens]
            problem, noises = pose(specimens, settings.noise)
            first = plain_model(problem)
        found = relative_stiffness(first)
        stiffness = found if scatter(found) > usual else {}  # no more than scales may be
        alike = [specimen.with_own(stiffness=stiffness) for specimen in specimens]
        if stiffness:
            problem, noises = pose(alike, settings.noise)
        return cls(alike, problem, noises, first, stiffness, contact)

    def open_to(self, effects: Sequence[Effect], settings: LoopSettings) -> list[Effect]:
        """Those of effects that may be named: neither known to be absent, nor known already."""
        known = {*settings.absent, *([STIFFNESS] if self.stiffness else [])}
        return [effect for effect in effects if effect.name not in known]

    @property
    def spread(self) -> list[float]:
        """Standard deviation of a block of each test of the problem [N]."""
        return [noise.block for noise in self.noises]

    @property
    def plain(self) -> Fit:
        """Plain model with the stiffness of each specimen."""
        return plain_model(self.problem) if self.stiffness else self.first


def pose(every: Sequence[Specimen], settings: NoiseSettings) -> tuple[Problem, list[Noise]]:
    """The records with their noise; the discrepancy needs a first fit of the material.

    The problem works with `PER_BLOCK` means of samples in a block, which say as much. What is held
    out of the records is no part of it.
    """
    most = most_blocks(len(every))
    specimens = [s for s in every if not s.out(block_size(s, settings, most)).all()]
    most = most_blocks(len(specimens))
    cells = [specimen.cell for specimen in specimens]
    noises = shared([measure_noise(specimen, settings, most) for specimen in specimens], cells)
    specimens = [
        specimen.reduced(max(1, noise.size // PER_BLOCK))
        for specimen, noise in zip(specimens, noises, strict=True)
    ]
    nothing = [np.zeros_like(s.force) for s in specimens]
    whiteners = _whiteners(specimens, noises, nothing, settings)
    rough = Problem(specimens, whiteners, settings).fit_material()
    material = rough.state.material
    travels = [rough.model.travel(s, rough.state) for s in specimens]
    predicted = [rough.model.predict(s, rough.state) for s in specimens]
    whiteners = _whiteners(specimens, noises, predicted, settings)
    lower = [
        material.mu
        * s.stiffness
        * s.elastic.ratio_change_per_mu(
            material.mu1_fraction, travel, s.elastic.poisson_ratio - settings.poisson_ratio
        )
        for s, travel in zip(specimens, travels, strict=True)
    ]
    largest = max(np.abs(x).max() / s.peak for s, x in zip(specimens, lower, strict=True))
    small = min(1.0, 0.01 * settings.form_percent / max(float(largest), 1e-300))
    lower = [small * x for x in lower]  # beyond, no such error goes with its size
    unseen = [specimen for specimen in every if specimen.held_out.any()]
    posed = Problem(specimens, whiteners, settings, material, lower, unseen)
    return posed, noises


def _whiteners(
    specimens: Sequence[Specimen],
    noises: Sequence[Noise],
    models: Sequence[Array],
    settings: NoiseSettings,
) -> list[Whitener]:
    """Whitener of every test, its scale by what a model predicts per sample [N]."""
    most = most_blocks(len(specimens))
    sizes = [block_size(s, settings, most) for s in specimens]
    longest = max(memory(s, size) for s, size in zip(specimens, sizes, strict=True))
    found = []
    for s, noise, model, size in zip(specimens, noises, models, sizes, strict=True):
        known, discrepancy = covariances(s, noise, blocks(model, size), settings, size, longest)
        found.append(Whitener(known, size, ~s.out(size), discrepancy))
    return in_common(specimens, found, settings)
