"""Predicted records: elastic curve, material, effects."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from softsample.loop.effects.base import MODES, Effect, Parameter, Values
from softsample.loop.specimen import FORCE, Array, Mask, Specimen
from softsample.response.changes import part_of

ITERATIONS, CLOSE = 20, 1e-9
"""Of the travel under a machine that yields: how many, and the part of the reach that is exact."""

SOFTEST, STIFFEST = 0.1, 1e8
"""Moduli [Pa] between which fits go."""

STEP = 1e-3
"""Part of the reach over which the slope of the elastic force is taken."""


@dataclass(frozen=True)
class Material:  # ASSUME: samples of a group are of one animal and region, hence of one material.
    """The material that the samples of a group share.

    Parameters
    ----------
    mu : float
        Shear modulus [Pa].
    mu1_fraction : float
        mu1 / mu, dimensionless.
    """

    mu: float
    mu1_fraction: float


@dataclass(frozen=True)
class Model:
    """A set of active effects.

    Parameters
    ----------
    effects : tuple of Effect
        In the order in which they were added.
    """

    effects: tuple[Effect, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects."""
        return tuple(effect.name for effect in self.effects)

    @property
    def parameters(self) -> list[tuple[Effect, Parameter]]:
        """All parameters of all effects."""
        return [(effect, p) for effect in self.effects for p in effect.parameters]

    @property
    def known(self) -> list[tuple[Effect, Parameter, tuple[float, float]]]:
        """Parameters of which a mean and a standard deviation are known."""
        return [(effect, p, p.known) for effect, p in self.parameters if p.known]

    @property
    def law(self) -> "Model":
        """The model with another law, if it has one, and no other effect."""
        return Model(tuple(effect for effect in self.effects if effect.is_law))

    @cached_property
    def _lawless(self) -> "Model":
        """The model with the study's law."""
        return Model(tuple(effect for effect in self.effects if not effect.is_law))

    def admits(self, effect: Effect) -> bool:
        """Whether an effect may be added."""
        return not any(one.excludes(effect) for one in self.effects)

    @cached_property
    def _acting(self) -> dict[str, list[Effect]]:
        """Effects that change tests of each kind: fits ask again and again."""
        return {kind: [e for e in self.effects if kind in e.modes] for kind in MODES}

    def travel(self, specimen: Specimen, state: "State") -> Array:
        """Travel that reaches the sample (n,) [m]."""
        return self._loading(specimen, state)[0]

    def predict(self, specimen: Specimen, state: "State") -> Array:
        """Force in the specimen's channel at every sample of the record (n,) [N].

        The one function that predicts a record.
        """
        travel, force = self._loading(specimen, state)
        return self.reading(specimen, force, travel, state.values) + self._crosstalk(
            specimen, state
        )

    def _crosstalk(self, specimen: Specimen, state: "State") -> Array | float:
        """What a normal force reads of the predicted force along the displacement (n,) [N]."""
        acting = self._acting[specimen.kind]
        if specimen.partner is None or not any(effect.crosstalk for effect in acting):
            return 0.0
        _, along = self._loading(specimen.partner, state)
        values = state.values
        return np.asarray(
            sum(e.crosstalk(specimen, along, values[e.name]) for e in acting if e.crosstalk)
        )

    def _loading(self, specimen: Specimen, state: "State") -> tuple[Array, Array]:
        """Travel that reaches the sample (n,) [m], and the force on it (n,) [N].

        Sample and machine are springs in series: what the machine reports is the travel plus the
        compliance times the force. The first step is Newton's, with the elastic slope; then that
        of each point is the slope between its last two travels, where these are apart.
        """
        reported = self._reported(specimen, state)
        travel, force = reported, self._force(specimen, state, reported)
        values, acting = state.values, self._acting[specimen.kind]
        compliance = sum(e.compliance(specimen, values[e.name]) for e in acting if e.compliance)
        if not compliance:
            return travel, force
        slope, close = self._slope(specimen, state, travel), CLOSE * specimen.reach
        for _ in range(ITERATIONS):
            excess = travel + compliance * force - reported
            if np.abs(excess).max() < close:
                break
            step = -excess / (1.0 + compliance * slope)
            further = self._force(specimen, state, travel + step)
            apart = np.abs(step) > close
            secant = np.divide(further - force, step, out=np.zeros_like(step), where=apart)
            slope = np.where(apart & (secant > 0.0), secant, slope)
            travel, force = travel + step, further
        return travel, force

    def _reported(self, specimen: Specimen, state: "State") -> Array:
        """Travel of the rigid machine (n,) [m]."""
        travel = specimen.travel
        if specimen.elastic.contact:
            travel = travel - 1e-3 * (state.contact_zero + specimen.contact)
        for effect in self._acting[specimen.kind]:
            if effect.travel:
                travel = effect.travel(specimen, travel, state.values[effect.name])
        return travel

    def _elastic(self, specimen: Specimen, state: "State", travel: Array) -> Array:
        """Elastic force (n,) [N], without history.

        What changes shape, boundary or compressibility changes the same part of the force along the
        displacement, whatever the law; fibres add the same. Either way an uneven face counts.
        """
        fraction = state.material.mu1_fraction
        model = specimen.elastic.force_per_mu(fraction, travel)
        force = added = self._of_law(specimen, state, travel, model)
        for effect in self._acting[specimen.kind]:
            if effect.elastic and not effect.is_law:
                change = effect.elastic(specimen, fraction, travel, state.values[effect.name])
                if specimen.channel == FORCE:
                    whole = force
                    if effect.beside:
                        whole = self._lawless._of_law(specimen, state, travel, model)
                    change = change * part_of(model, whole)
                added = added + change
        return np.asarray(state.material.mu * specimen.stiffness * added)

    def _of_law(self, specimen: Specimen, state: "State", travel: Array, model: Array) -> Array:
        """Force per modulus (n,) [m2] of the law, from that of the study's.

        Of columns side by side if the face is uneven.
        """
        acting, values = self._acting[specimen.kind], state.values
        columns, parts = travel[:, None], np.ones(1)
        for effect in acting:
            if effect.heights:
                depths, weights = effect.heights(specimen, values[effect.name])
                if depths.any():
                    columns = (columns[:, :, None] - depths).reshape(len(travel), -1)
                    parts = np.outer(parts, weights).ravel()
        uneven = len(parts) > 1
        every = columns.ravel() if uneven else travel
        fraction = state.material.mu1_fraction
        force = specimen.elastic.force_per_mu(fraction, every) if uneven else model
        for effect in acting:
            if effect.is_law and effect.elastic:
                force = force + effect.elastic(specimen, fraction, every, values[effect.name])
        return np.asarray(force.reshape(columns.shape) @ parts) if uneven else force

    def _slope(self, specimen: Specimen, state: "State", travel: Array) -> Array:
        """Slope of that force (n,) [N/m], not negative."""
        step = STEP * specimen.reach
        ahead, here = (self._elastic(specimen, state, x) for x in (travel + step, travel))
        return np.asarray(np.maximum((ahead - here) / step, 0.0))

    def _force(self, specimen: Specimen, state: "State", travel: Array) -> Array:
        """Force on the sample (n,) [N] for a travel that reaches it."""
        force, values = self._elastic(specimen, state, travel), state.values
        acting = self._acting[specimen.kind]
        for effect in acting:
            if effect.tissue:
                force = effect.tissue(specimen, force, travel, values[effect.name])
        for effect in acting:
            if effect.contact:
                force = effect.contact(specimen, force, travel, values[effect.name])
        if specimen.elastic.contact and specimen.elastic.release:  # the platen leaves it
            force = np.maximum(force, 0.0)
        elif np.isfinite(specimen.elastic.most_push):  # one that is slender buckles
            modulus = state.material.mu * specimen.stiffness
            force = np.maximum(force, -modulus * specimen.elastic.most_push)
        return force

    def reading(
        self, specimen: Specimen, force: Array, travel: Array, values: Mapping[str, Values]
    ) -> Array:
        """What the instrument makes of a force (n,) [N]; only of that along the displacement."""
        for effect in self._acting[specimen.kind] if specimen.channel == FORCE else ():
            if effect.instrument:
                force = effect.instrument(specimen, force, travel, values[effect.name])
        return force

    def with_effect(self, effect: Effect) -> "Model":
        """The model with one more effect."""
        return Model((*self.effects, effect))

    def without(self, name: str) -> "Model":
        """The model with one effect less."""
        return Model(tuple(effect for effect in self.effects if effect.name != name))


@dataclass(frozen=True)
class State:
    """A material, values of all effects of a model, and what is only known within a prior.

    Parameters
    ----------
    material : Material
        Of the group.
    values : mapping
        Values of the parameters by effect.
    contact_zero : float
        Travel at which compression begins [mm].
    """

    material: Material
    values: Mapping[str, Values] = field(default_factory=dict)
    contact_zero: float = 0.0

    def with_values(self, name: str, values: Mapping[str, float]) -> "State":
        """The same with values of one effect."""
        return replace(self, values={**self.values, name: {**values}})


FIXED, FRACTION, CONTACT_ZERO = 3, 1, 2
"""Entries of a packed state before the effects: ln mu, r, contact-point offset; and two places."""


class Packing:
    """Between a state and the vector that a fit moves: ln mu, r, contact zero, all parameters.

    Parameters of effects are scaled by their range.

    Parameters
    ----------
    model : Model
        Its effects.
    bounds : tuple of float
        Least and largest r of the simulated families.
    """

    def __init__(self, model: Model, bounds: tuple[float, float]) -> None:
        self.model = model
        self.low = np.array(
            [np.log(SOFTEST), bounds[0], -1.0, *(p.low / _unit(p) for _, p in model.parameters)]
        )
        self.high = np.array(
            [np.log(STIFFEST), bounds[1], 1.0, *(p.high / _unit(p) for _, p in model.parameters)]
        )

    def pack(self, state: State) -> Array:
        """Vector of a state."""
        parts = [state.values[e.name][p.name] / _unit(p) for e, p in self.model.parameters]
        head = np.log(state.material.mu), state.material.mu1_fraction, state.contact_zero
        return np.array([*head, *parts])

    def at_end(self, state: State) -> Mask:
        """Which entries of the vector of a state lie at an end of their range."""
        vector, near = self.pack(state), 1e-3 * (self.high - self.low)
        return np.asarray((vector < self.low + near) | (vector > self.high - near))

    def unpack(self, vector: Array) -> State:
        """State of a vector."""
        values: dict[str, Values] = {effect.name: {} for effect in self.model.effects}
        log_mu, fraction, contact_zero, *packed = vector.tolist()
        for (effect, p), x in zip(self.model.parameters, packed, strict=True):
            values[effect.name][p.name] = x * _unit(p)
        return State(Material(math.exp(log_mu), fraction), values, contact_zero)


def _unit(parameter: Parameter) -> float:
    return parameter.high - parameter.low


def residuals(model: Model, specimens: Sequence[Specimen], state: State) -> list[Array]:
    """Measured less predicted force of every test, per sample [N]."""
    return [s.force - model.predict(s, state) for s in specimens]
