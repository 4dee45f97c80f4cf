"""Records whose zero of force or travel is not that of their siblings, found without being told."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from operator import attrgetter
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.measured.measurement import Measurement
from softsample.protocol import travel_sign

Array = NDArray[np.float64]

THRESHOLD = 2.24
"""Deviations of this many robust standard deviations count: 2.5 % of records that are like their
siblings pass it by chance, and few of those that are more than three off do not."""

COMPARED = (0.01, 0.2)
"""Nominal strains between which curves are laid over each other."""

FORCE, TRAVEL = "force_offset", "displacement_zero"
WHY = {
    FORCE: "force at zero travel: the cell was not at its zero when the test began",
    TRAVEL: "curve of its siblings, but shifted: zero of travel not at contact, or a late contact",
}


def odd_zeros(tests: Sequence[Measurement], cells: Mapping[str, str]) -> pd.DataFrame:
    """Deviation of every record's zeros from those of its siblings.

    The zero of force belongs to the load cell: it is compared with the median of all records of
    that cell and judged by their scatter. The zero of travel is
    compared with the median of the specimen's repeats and judged by the scatter of all records.

    Parameters
    ----------
    tests : sequence of Measurement
        Records of one way of testing; all those of a specimen are repeats.
    cells : mapping
        Load cell of each record by its name; records without one are passed over.

    Returns
    -------
    DataFrame
        One row a record and channel: `record`, `effect` (`force_offset`, `displacement_zero`),
        `class` (names that this record cannot tell apart), `size`, `unit`, `sigmas` (deviation
        over the robust scatter), `found`, `why`.
    """
    tests = [test for test in tests if test.name in cells]
    of_cell = {test.name: cells[test.name] for test in tests}
    force = _beyond_median({test.name: _force_at_zero(test) for test in tests}, of_cell)
    travel = _shifts(tests)
    judged = [
        (FORCE, FORCE, "N", force, of_cell),
        (TRAVEL, f"{TRAVEL}|late_contact", "mm", travel, {t.name: "all" for t in tests}),
    ]
    rows = []
    for effect, members, unit, sizes, scattered in judged:
        scatter = _robust_scatter(sizes, scattered)
        for test in tests:
            sigmas = sizes[test.name] / scatter[scattered[test.name]]
            found = abs(sigmas) > THRESHOLD
            why = WHY[effect] if found else ""
            rows.append((test.name, effect, members, sizes[test.name], unit, sigmas, found, why))
    names = ("record", "effect", "class", "size", "unit", "sigmas", "found", "why")
    return pd.DataFrame(rows, columns=list(names)).astype({"found": bool})


def _force_at_zero(test: Measurement) -> float:
    """First force along the loading [N], before the platen moves."""
    return travel_sign(test.mode) * float(test.record.force[0])


def _shifts(tests: Sequence[Measurement]) -> dict[str, float]:
    """How much later than its siblings each record rises [mm].

    Its distance from the median of the repeats, once the zero of force is taken off, is
    ``c F - d F'``: a factor of stiffness and a shift.
    """
    found: dict[str, float] = {}
    key = attrgetter("group", "specimen")
    for _, repeats in groupby(sorted(tests, key=key), key=key):
        group = list(repeats)
        low, high = (part * group[0].shape.height for part in COMPARED)
        travel = np.linspace(low, high, 100)
        curves = np.stack([_curve(test, travel) for test in group])
        middle = np.median(curves, axis=0)
        columns = np.stack([middle, -np.gradient(middle, travel)], axis=1)
        sizes, *_ = np.linalg.lstsq(columns, (curves - middle).T, rcond=None)
        found |= {test.name: 1e3 * float(d) for test, d in zip(group, sizes[1], strict=True)}
    return found


def _curve(test: Measurement, travel: Array) -> Array:
    """Force along the loading at travels [m], its first value taken off."""
    sign = travel_sign(test.mode)
    force = sign * (test.record.force - test.record.force[0])
    return np.interp(travel, sign * test.record.displacement, force)


def _beyond_median(values: Mapping[str, float], group: Mapping[str, str]) -> dict[Any, float]:
    """Values less the median of their group."""
    series, groups = pd.Series(values), pd.Series(group)
    return dict((series - series.groupby(groups).transform("median")).items())


def _robust_scatter(values: Mapping[str, float], group: Mapping[str, str]) -> dict[Any, float]:
    """Standard deviation by group, from the median of the distances from zero."""
    scatter = 1.4826 * pd.Series(values).abs().groupby(pd.Series(group)).median()
    return dict(scatter.items())
