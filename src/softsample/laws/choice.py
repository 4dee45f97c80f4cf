"""Which law predicts what it has not seen, and which others do as well.

The log likelihood of what a fold leaves out is taken at the error's own size, -ln(error) per
independent point: how large the model's error is, is estimated, so that no assumed size makes it
over-sharp. A law is as good as the best if it is worse by one standard error of the difference over
the folds at most; of these the simplest is recommended. A law of fewer parameters that the fitted
records do not reject beside the best one is as good too, but is not recommended for that.

References
----------
L. Breiman, J. H. Friedman, R. A. Olshen, C. J. Stone, Classification and Regression Trees,
Wadsworth 1984, section 3.4.3 (the one-standard-error rule).
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softsample.laws.candidates import Candidate
from softsample.laws.folds import LEAST_ERROR

FEWEST_FOLDS = 2
"""Folds below which no choice is made."""

REFUSED = "one loading curve of one mode cannot tell laws apart: {folds}; test another mode"
"""Why no choice is made."""


@dataclass(frozen=True)
class Choice:
    """Laws compared by their errors on the same folds.

    Parameters
    ----------
    score : dict of float
        Mean held-out log likelihood per independent point, by law.
    behind, standard_error : dict of float
        Mean difference to the best law, and its standard error over the folds; none if refused.
    equal : tuple of str
        Laws that are as good as the best: those that predict as well, the simplest first, then
        simpler ones that fit as well.
    folds : int
        Number of folds.
    refused : str
        Why there is no choice; empty if there is one.
    """

    score: dict[str, float]
    behind: dict[str, float]
    standard_error: dict[str, float]
    equal: tuple[str, ...]
    folds: int
    refused: str = ""

    @property
    def recommended(self) -> str | None:
        """The simplest of the laws that are as good as the best; None if refused."""
        return self.equal[0] if self.equal else None


def choose(
    candidates: Sequence[Candidate],
    errors: Mapping[str, Sequence[float]],
    simpler: Mapping[str, Collection[str]],
) -> Choice:
    """Compare laws on folds.

    Parameters
    ----------
    errors : mapping
        Errors on the folds, as parts of the peak, by name of the law; the same folds for all.
    simpler : mapping
        Laws that the fitted records do not reject beside each.
    """
    names = [candidate.name for candidate in candidates]
    # log likelihood per independent point
    table = -0.5 * np.array(
        [[np.log(error**2 + LEAST_ERROR**2) for error in errors[name]] for name in names]
    )
    folds = table.shape[1]
    means = table.mean(axis=1) if folds else np.zeros(len(names))
    score = dict(zip(names, means.tolist(), strict=True))
    if folds < FEWEST_FOLDS:
        there = "there is nothing to leave out but its last part" if folds else "no fold is left"
        return Choice(score, {}, {}, (), folds, REFUSED.format(folds=there))
    best = int(np.argmax(means))
    gap = table[best] - table
    behind, scatter = gap.mean(axis=1), gap.std(axis=1, ddof=1) / np.sqrt(folds)
    sizes = {candidate.name: candidate.size for candidate in candidates}
    equal = [name for name, b, s in zip(names, behind, scatter, strict=True) if b <= s]
    equal.sort(key=lambda name: (sizes[name], -score[name]))
    return Choice(
        score,
        dict(zip(names, behind.tolist(), strict=True)),
        dict(zip(names, scatter.tolist(), strict=True)),
        (*equal, *(n for n in names if n in simpler.get(names[best], ()) and n not in equal)),
        folds,
    )
