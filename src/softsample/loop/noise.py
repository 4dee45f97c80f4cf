"""How far a force record can be trusted: noise of the cell, and what the model cannot resolve."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from weakref import ref

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from softsample.loop.specimen import Array, Mask, Specimen, blocks
from softsample.record_noise import SCATTER, SURE, beyond_polynomial, last_digit, white_noise

KINDS = ("baseline", "ramp", "hold", "unloading")
"""Phases of a record."""

STILL = ("baseline", "hold")
"""Those in which the platen rests."""

MOST_BLOCKS, MOST_OF_GROUP, FEWEST = 1000, 3000, 100
"""Blocks of a record at most, as its covariance is a full matrix, and of all tests of a group, each
of which may have `FEWEST`."""

FORM = "form"
"""Part of the discrepancy that is error in the form of the effects that were chosen."""


def _rational_quadratic(apart: Array, length: float) -> Array:
    """Rational quadratic of exponent 2: the mean of Gaussian correlations over many lengths."""
    return np.asarray((1.0 + 0.25 * (apart / length) ** 2) ** -2.0)


def _matern(apart: Array, length: float) -> Array:
    """Matern's correlation 3/2: it has a slope, but need not bend smoothly."""
    steps = np.sqrt(3.0) * np.abs(apart) / length
    return np.asarray((1.0 + steps) * np.exp(-steps))


Covariance = Array | Callable[[], Array]
"""Covariance (n, n) [N2], or what makes it: of vectors that is as quick, and no fit keeps it."""

MOST_ENTRIES = 2 * 10**7
"""Of the factors of covariances that are kept, together: the latest ones. A fit asks for its own
again and again; those of all models that a selection came to would fill the memory."""

Similarity = Callable[[Array, float], Array]
"""Correlation over distances of given length."""

SIMILARITY: dict[str, Similarity] = {"smooth": _rational_quadratic, "kinked": _matern}
"""Parts of the discrepancy that go with the travel: no one knows how smooth it is.

C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning (2006), section 4.2,
doi:10.7551/mitpress/3206.001.0001.
"""

GEOMETRY = (*SIMILARITY, "history")
"""Parts of the discrepancy that errors of geometry, mesh and element type make."""

AT_MOST_STATED = ("smooth", "wander", FORM)
"""Parts that are no larger than the settings say: larger, they would do what effects do."""

FURTHEST = 4.0
"""Standard deviations of its prior that a size is sought from its median."""

GRAIN_LENGTH = 0.01
"""Correlation length of discretisation noise, a part of the largest displacement: points of a curve
are 1/60 of it apart."""


@dataclass(frozen=True)
class NoiseSettings:
    """Mirrors config `loop: noise:`.

    Parameters
    ----------
    block_s : float
        Records are averaged over blocks of this length [s].
    correlation_s : float
        Correlation time of the slow part of the cell's noise [s].
    floor_percent : float
        Smooth error of the model that no effect explains [% of the peak force of a test]: mesh,
        element type, segmentation. Either kind of `SIMILARITY` has half of its variance.
    floor_length : float
        Its correlation length, as a part of the stroke.
    fine_percent, fine_length : float
        The same for error that is rough, as that of the size of elements or of a platen that
        sticks and slips.
    history_percent : float
        The same for error that changes in the course of a test too, so that loading and unloading
        differ, its correlation time is `memory`; and for what wanders once the platen has moved,
        over the longest `memory` of a group.
    scale_percent : float
        Standard deviation of the scale of each test [%]: element type, volume, glued area.
    contact_zero_mm : float
        Standard deviation of the height of the highest point [mm]; where compression begins is
        fitted with this prior, so that only a gap beyond it counts as an effect.
    form_percent : float
        Error in the form of an effect that has been chosen, in percent of its contribution, at
        most; what comes after has to explain more than that.
    poisson_ratio : float
        Standard deviation of the Poisson's ratio about that of the model; all tests share it.
    spread : float
        Factor by which the sizes above may be larger or smaller, `AT_MOST_STATED` smaller alone,
        one standard deviation: they are estimated from the records. 1 takes them as they are.
    """

    block_s: float = 0.2
    correlation_s: float = 1.0
    floor_percent: float = 1.0
    floor_length: float = 0.25
    fine_percent: float = 0.3
    fine_length: float = 0.05
    history_percent: float = 0.3
    scale_percent: float = 2.0
    contact_zero_mm: float = 0.06
    form_percent: float = 5.0
    poisson_ratio: float = 0.0005
    spread: float = 2.0

    def sizes(self, variances: Mapping[str, float]) -> dict[str, float]:
        """Sizes of the parts of the discrepancy [%], of factors of their variances."""
        stated = {
            **dict.fromkeys(SIMILARITY, self.each_percent),
            "rough": self.fine_percent,
            **dict.fromkeys(("history", "wander"), self.history_percent),
            "scale": self.scale_percent,
            FORM: self.form_percent,
        }
        return {name: float(stated[name] * np.sqrt(v)) for name, v in variances.items()}

    @property
    def each_percent(self) -> float:
        """Of each of the parts that are of `SIMILARITY`: they have equal variances [%]."""
        return float(self.floor_percent / np.sqrt(len(SIMILARITY)))

    @property
    def largest_scale(self) -> float:
        """End of the range of the scale of tests [%], but for rounding."""
        return float(0.999 * self.scale_percent * self.spread**FURTHEST)

    def sharp(self, variances: Mapping[str, float]) -> dict[str, float]:
        """Factors of the variances that are none above 1, and the least for that of form."""
        most = {FORM: self.spread ** (-2.0 * FURTHEST)}
        return {name: min(most.get(name, 1.0), v) for name, v in variances.items()}

    def doubt(self, shown: Mapping[str, float], geometry: bool) -> dict[str, float]:
        """Least factors of variances with errors that may be larger along an effect than elsewhere.

        `spread` times as large: errors of form as in the settings, with `geometry` those of that
        and of the mesh as in the settings, or in the factors that records show if these are larger.
        What wanders is as in the settings: most of a linear drift looks like it.
        """
        least = {name: max(1.0, shown.get(name, 0.0)) for name in GEOMETRY} if geometry else {}
        larger = {name: self.spread**2 * factor for name, factor in {FORM: 1.0, **least}.items()}
        return {"wander": 1.0, **larger}


@dataclass(frozen=True)
class Noise:
    """Noise of one record.

    Parameters
    ----------
    white : float
        Standard deviation of a sample [N].
    slow : float
        Standard deviation of the correlated part [N].
    size : int
        Samples in a block.
    samples : int
        From so many differences the white noise is known; 0 if it is not from the record.
    """

    white: float
    slow: float
    size: int
    samples: int = 0

    @property
    def block(self) -> float:
        """Standard deviation of the mean of a block [N]."""
        return float(np.hypot(self.white / np.sqrt(self.size), self.slow))


def most_blocks(tests: int) -> int:
    """Blocks of each record of a group of tests, at most."""
    return min(MOST_BLOCKS, max(FEWEST, MOST_OF_GROUP // tests))


def block_size(specimen: Specimen, settings: NoiseSettings, most: int = MOST_BLOCKS) -> int:
    """Samples in a block, and no more blocks than `most`.

    In a fast ramp a block is no longer than what is rough along the travel.
    """
    enough = -(-len(specimen.time) // most)
    usual = round(settings.block_s / float(np.median(np.diff(specimen.time))))
    ramps = [
        part.stop - part.start
        for part in specimen.stretches
        if specimen.phase[part.start] == "ramp" and not specimen.held_out[part.start]
    ]
    fine = round(settings.fine_length * max(ramps)) if ramps else usual
    return max(1, enough, min(usual, fine))


def measure_noise(specimen: Specimen, settings: NoiseSettings, most: int = MOST_BLOCKS) -> Noise:
    """White noise from differences, slow noise from what block means vary more than that.

    Block means are taken over 5 s in which the platen rests, less a parabola, or where there are
    no two of these over 5 s, at least 8 blocks, of any phase, less a polynomial of fifth degree;
    what that takes from noise of the given correlation time is made good. None reaches across a
    corner of the record. Where a reading's last digit is coarser than its noise, the error of
    rounding is noise too, and one that goes on from sample to sample. What is held out is not read.
    """
    size, fitted = block_size(specimen, settings, most), ~specimen.held_out
    at = specimen.time if specimen.timed else specimen.travel
    white, number = white_noise(at, specimen.force, fitted)
    rounding = last_digit(specimen.force[fitted]) / np.sqrt(12.0)
    least = rounding if white < rounding else 0.0
    white = max(white, rounding)
    block = size * float(np.median(np.diff(specimen.time)))
    long = max(8, round(5.0 / block))
    chunks, degree = _windows(specimen, size, long, STILL), 2
    if len(chunks) < 2:
        chunks, degree = _windows(specimen, size, long) or _windows(specimen, size, 8), 5
    if not chunks:
        return Noise(white, least, size, number)
    found = [
        beyond_polynomial(time, means, degree, settings.correlation_s) for time, means in chunks
    ]
    variance, share, left = np.median(found, axis=0)
    excess = variance - left * white**2 / size
    slow = max(least, float(np.sqrt(max(excess, 0.0) / share)))
    return Noise(white, slow, size, number)


def _windows(
    specimen: Specimen, size: int, window: int, kinds: Sequence[str] = KINDS
) -> list[tuple[Array, Array]]:
    """Times (window,) [s] and means [N] of as many blocks as fill a window, within one phase.

    Where time was not recorded and the platen moves, its way in mean steps stands for the time:
    readings may lie unevenly.
    """
    steps = np.abs(np.diff(specimen.travel, prepend=specimen.travel[0]))
    way = np.cumsum(steps) / max(float(steps.mean()), 1e-300)
    found = []
    for part in specimen.stretches:
        kind = str(specimen.phase[part.start])
        if kind in kinds and not specimen.held_out[part.start]:
            at = specimen.time if specimen.timed or kind in STILL else way
            time, means = (blocks(x[part], size) for x in (at, specimen.force))
            starts = range(0, len(means) - window + 1, window)
            found += [(time[k : k + window], means[k : k + window]) for k in starts]
    return found


def shared(noises: Sequence[Noise], cells: Sequence[str]) -> list[Noise]:
    """Noise of records of one cell: the medians, as one record alone shows it but roughly.

    A record whose white noise is not the median's, beyond its error, has another cell, range or
    amplifier: it keeps its own, and its slow noise is as much larger.

    Parameters
    ----------
    noises : sequence of Noise
        Of each record by itself.
    cells : sequence of str
        What the cell of each measures: `torque` or `force`.
    """
    of = {
        cell: np.median(
            [(n.white, n.slow) for n, c in zip(noises, cells, strict=True) if c == cell], axis=0
        )
        for cell in set(cells)
    }
    return [_known(noise, *of[cell]) for noise, cell in zip(noises, cells, strict=True)]


def _known(noise: Noise, white: float, slow: float) -> Noise:
    """The noise of a record in a group whose medians are known."""
    error = SURE * SCATTER / np.sqrt(max(noise.samples, 1))
    if min(noise.white, white) > 0.0 and abs(np.log(noise.white / white)) > error:
        return replace(noise, slow=float(slow * noise.white / white))
    return replace(noise, white=float(white), slow=float(slow))


def moved(specimen: Specimen, size: int) -> Array:
    """A percent of the peak at every block (n,) [N], nothing before the platen moves."""
    onset = np.clip(np.abs(specimen.travel) / (0.02 * specimen.reach), 0.0, 1.0)
    return np.asarray(0.01 * specimen.peak * blocks(onset, size))


def memory(specimen: Specimen, size: int) -> float:
    """Correlation time [s] of errors that change in the course of a test: a quarter of it."""
    fitted = ~specimen.out(size)
    time = blocks(specimen.time, size)[fitted]
    return 0.25 * max(float(np.ptp(time)), 1e-9) if fitted.any() else 0.25


def covariances(
    specimen: Specimen,
    noise: Noise,
    model: Array,
    settings: NoiseSettings,
    size: int,
    wander_s: float = 0.0,
) -> tuple[Array, dict[str, Array]]:
    """Covariances (n, n) [N2] of the block means of one test.

    Parameters
    ----------
    specimen : Specimen
        The test.
    noise : Noise
        Of its record.
    model : (n,) float64
        Force that a first fit of the material predicts at the blocks [N], for the scale.
    settings : NoiseSettings
        What the model does not resolve, beside the grain of its curves. Its smooth error goes
        with the travel, so that loading and unloading share it, and is nothing before the platen
        moves.
    size : int
        Samples of the specimen in a block.
    wander_s : float
        Correlation time of what wanders [s], its own `memory` at least: it is of the machine.

    Returns
    -------
    known : (n, n) float64
        Of the cell's noise and the grain.
    discrepancy : dict of (n, n) float64
        Of what the model does not resolve, by part, at the sizes of the settings.
    """
    time, travel = blocks(specimen.time, size), blocks(specimen.travel, size)
    lag = np.abs(np.subtract.outer(time, time))
    apart = np.subtract.outer(travel, travel) / specimen.reach
    percents = moved(specimen, size)
    since = np.maximum.accumulate(percents)  # what has moved comes to rest elsewhere

    def along(percent: float, alike: Array, by: Array = percents) -> Array:
        return np.asarray(percent**2 * np.outer(by, by) * alike)

    known = noise.white**2 / noise.size * np.eye(len(time))
    known += noise.slow**2 * np.exp(-lag / settings.correlation_s)
    known += along(100.0 * specimen.elastic.grain, np.exp(-0.5 * (apart / GRAIN_LENGTH) ** 2))
    scale = 0.01 * settings.scale_percent * model
    alike = {name: of(apart, settings.floor_length) for name, of in SIMILARITY.items()}
    long = memory(specimen, size)
    return known, {
        **{name: along(settings.each_percent, smooth) for name, smooth in alike.items()},
        "rough": along(settings.fine_percent, np.exp(-np.abs(apart) / settings.fine_length)),
        "history": along(settings.history_percent, alike["kinked"] * np.exp(-lag / long)),
        "wander": along(settings.history_percent, _matern(lag, max(long, wander_s)), since),
        "scale": np.outer(scale, scale),
    }


_FACTORED: "deque[tuple[ref[Whitener], int]]" = deque()
"""Whiteners in the order in which they were factorised, and entries of each factor."""


@dataclass(frozen=True, eq=False)
class Whitener:
    """Turns residuals of one test into independent unit noise.

    Parameters
    ----------
    known : (n, n) float64
        Covariance of the blocks whose size is known [N2].
    size : int
        Samples in a block.
    keep : (n,) bool
        Blocks that count; the others are left out (folds).
    discrepancy : mapping of Covariance, optional
        Of what the model does not resolve, by part, that are the test's own.
    variances : mapping of float, optional
        Factors of these; 1 by default.
    shared : mapping of (n, k) float64, optional
        Of parts in which other tests have a share: what each of k variates that tests have in
        common adds, one standard deviation [N].
    slot : int, optional
        Which of those of the scale is that of this test.
    """

    known: Array
    size: int
    keep: Mask
    discrepancy: Mapping[str, Covariance] = field(default_factory=dict)
    variances: Mapping[str, float] = field(default_factory=dict)
    shared: Mapping[str, Array] = field(default_factory=dict)
    slot: int | None = None

    def __post_init__(self) -> None:
        each = dict.fromkeys(self.discrepancy, 1.0) | dict(self.variances)
        object.__setattr__(self, "variances", each)

    def part(self, name: str) -> Array:
        """Covariance (n, n) [N2] of a part of the discrepancy that is the test's own."""
        return _made(self.discrepancy[name])

    @cached_property
    def _factor(self) -> Array:
        """Cholesky factor of the test's own covariance of the blocks that count; see `_drop`."""
        part = np.array(self.kept(self.known))
        for name in self.discrepancy:
            part += self.variances[name] * self.kept(self.part(name))
        part.flat[:: len(part) + 1] += 1e-12 * np.trace(part) / max(len(part), 1)
        _FACTORED.append((ref(self), part.size))
        _drop(MOST_ENTRIES)
        # symmetric: in the order of columns it is factorised in place
        return np.asarray(cholesky(part.T, lower=True, overwrite_a=True, check_finite=False))

    def kept(self, matrix: Array) -> Array:
        """Part of a matrix (n, n) that is of the blocks that count."""
        return matrix if self.keep.all() else matrix[np.ix_(self.keep, self.keep)]

    @property
    def variance(self) -> Array:
        """Of the blocks that count (n_blocks,) [N2], with what other tests have a share in."""
        found = np.diag(self.known).copy()
        for name in self.discrepancy:
            found += self.variances[name] * np.diag(self.part(name))
        for name, columns in self.shared.items():
            found += self.variances[name] * np.sum(columns**2, axis=1)
        return np.asarray(found[self.keep])

    @cached_property
    def log_determinant(self) -> float:
        """Of the test's own covariance of the blocks that count."""
        return float(2.0 * np.log(np.diag(self._factor)).sum())

    def blocks(self, residual: Array) -> Array:
        """Block means of a residual per sample, of the blocks that count."""
        return blocks(residual, self.size)[self.keep]

    def __call__(self, residual: Array) -> Array:
        """White residual of the blocks that count, from one per sample (n_samples,) [N]."""
        return self._whitened(self.blocks(residual))

    def _whitened(self, means: Array) -> Array:
        return np.asarray(solve_triangular(self._factor, means, lower=True, check_finite=False))

    @property
    def in_common(self) -> Array:
        """White columns (n_blocks, k) of what other tests have a share in."""
        sizes = [np.sqrt(self.variances[name]) * part for name, part in self.shared.items()]
        every = np.hstack([np.zeros((len(self.keep), 0)), *sizes])
        return self._whitened(every[self.keep])

    @cached_property
    def alone(self) -> "Whitener":
        """The same if there were no other test."""
        if not self.shared:
            return self
        whole = {n: self.part(n) + (p @ p.T if (p := self.shared.get(n)) is not None else 0.0)
                 for n in self.discrepancy}  # fmt: skip
        return replace(self, discrepancy=whole, shared={}, slot=None)

    @property
    def without_scale(self) -> "Whitener":
        """The same if there were no other test and no error of scale."""
        return replace(self.alone, variances={**self.variances, "scale": 0.0})

    def coloured(self, white: Array) -> Array:
        """Block means with this covariance from independent unit noise (n_blocks, ...) [N]."""
        return np.asarray(self._factor @ white)

    def with_form(self, covariance: Covariance) -> "Whitener":
        """The same with more error in the form of effects [N2], as part `FORM`."""
        before = self.discrepancy.get(FORM)
        form = covariance if before is None else lambda: _made(before) + _made(covariance)
        return replace(self, discrepancy={**self.discrepancy, FORM: form})

    def with_scale(self, error: Array) -> "Whitener":
        """The same with another error of scale, one standard deviation of it (n,) [N]."""
        if self.slot is None:
            scale = partial(np.outer, error, error)
            return replace(self, discrepancy={**self.discrepancy, "scale": scale})
        columns = np.zeros_like(self.shared["scale"])
        columns[:, self.slot] = error
        return replace(self, shared={**self.shared, "scale": columns})

    def on(self, keep: Mask) -> "Whitener":
        """The same with other blocks."""
        return self if np.array_equal(keep, self.keep) else replace(self, keep=keep)


def _made(covariance: Covariance) -> Array:
    return covariance() if callable(covariance) else covariance


def _drop(most: int) -> None:
    """Let the oldest factors go until so many entries are left; they are made anew if asked for."""
    while sum(entries for _, entries in _FACTORED) > most and len(_FACTORED) > 1:
        oldest, _ = _FACTORED.popleft()
        if whitener := oldest():
            whitener.__dict__.pop("_factor", None)
