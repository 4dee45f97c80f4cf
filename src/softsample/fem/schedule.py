"""Solver time: how fast a loading history is run through."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from softsample.arrays import Array
from softsample.protocol import History, smooth_step

HOLD_SHARE = 0.25
"""Solver time of a hold, in parts of the loading time: nothing moves but what relaxes."""


@dataclass(frozen=True)
class Schedule:
    """A loading history in solver time, every leg by a smooth step of the test's own clock.

    The clock stands still at each corner, so that velocity and acceleration vanish there, and
    relaxation goes by the clock whatever the pace. A leg lasts as long as its inertia forces
    need: accelerations are those of a ramp of the whole reach in the loading time.

    Parameters
    ----------
    history : History
        Travel over the time of the test.
    loading_time : float
        Solver time of a ramp over the whole reach [s].
    settling : float
        Solver time before the first leg, in which a body force grows [s].
    """

    history: History
    loading_time: float
    settling: float = 0.0

    @property
    def tick(self) -> float:
        """Resolution of solver times [s]; slices much shorter than a step would divide by dust."""
        return 1e-4 * self.loading_time

    @property
    def corners(self) -> Array:
        """Solver times of the history's corners [s], the first at the end of the settling."""
        share = np.abs(np.diff(self.history.travel)) / self.history.reach
        legs = self.loading_time * np.where(share > 0.0, np.sqrt(share), HOLD_SHARE)
        return self.settling + np.concatenate([[0.0], np.cumsum(legs)])

    def clock(self, time: Array) -> Array:
        """The test's own time [s] at solver times [s]."""
        corners, clock = self.corners, self.history.time
        leg = np.clip(np.searchsorted(corners, time, side="right") - 1, 0, len(clock) - 2)
        fraction = (time - corners[leg]) / (corners[leg + 1] - corners[leg])
        return np.asarray(clock[leg] + (clock[leg + 1] - clock[leg]) * smooth_step(fraction))

    def travel(self, clock: Array | float) -> Array:
        """Travel of the platen [m] at times of the test [s]."""
        return np.asarray(np.interp(clock, self.history.time, self.history.travel))

    def gravity(self, time: Array) -> Array:
        """Part of the body force that acts at solver times [s]."""
        return smooth_step(time / self.settling) if self.settling > 0.0 else np.ones_like(time)

    def slices(self, number: int, stops: Array) -> Array:
        """Solver times [s] at which the march pauses: each leg in parts, and at `stops` [s].

        A leg as long as the loading time has `number` parts, another one as many as its share.
        """
        ends = np.concatenate([[0.0], self.corners] if self.settling > 0.0 else [self.corners])
        parts = [
            np.linspace(start, end, 1 + int(np.ceil(number * (end - start) / self.loading_time)))
            for start, end in pairwise(ends)
        ]
        ticks = np.round(np.concatenate([*parts, stops]) / self.tick)
        return np.unique(ticks) * self.tick

    def times(self, points: int) -> Array:
        """Times of the test [s] at which curves are given: `points` evenly spaced in each leg."""
        clock = self.history.time
        legs = [np.linspace(start, end, points + 1)[1:] for start, end in pairwise(clock)]
        return np.concatenate([[0.0], *legs])

    def solver_time(self, clock: Array) -> Array:
        """Solver times [s] of times of the test [s], by interpolation."""
        fine = np.linspace(self.settling, self.corners[-1], 20001)
        return np.interp(clock, self.clock(fine), fine)
