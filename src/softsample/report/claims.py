"""Each claim of the paper beside what the study found, judged by numbers of its tables."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from softsample.arrays import Array
from softsample.report.bond import RULES
from softsample.report.page import signed
from softsample.response.sensitivity import COARSE
from softsample.wording import true_minus

Tables = Mapping[str, pd.DataFrame]

REPRODUCED, DIFFERS, UNTESTABLE = "reproduced", "differs", "not testable"

ACCURATE = 5.0
"""Area between two curves [% of that below the record] up to which a fit is called accurate."""

CONFIDENCE, MOST, NEAR = 0.9, 0.5, 0.1
"""Of intervals; part of the strains that is most of them; relative distance of exponents that are
close."""

INDEPENDENT = 1.0
"""Change of a modulus [%] by elements of twice the size up to which a mesh is fine enough."""

ALIKE = 5.0
"""Difference of two forces [%] or of two biases [points] up to which they are alike."""

PART_OF_TEST = 0.15
"""Strain up to which contact has to be partial to be so in a significant portion of the test."""

FULL = 0.9
"""Part of the cuboid's contact area from which on contact is complete."""

AXIAL = "tension+compression"


@dataclass(frozen=True)
class Finding:
    """What became of a claim.

    Parameters
    ----------
    found : str
        What the study found, in words and numbers of its tables.
    verdict : str
        `reproduced`, `differs` or `not testable`.
    why : str
        What that rests on, and where a difference comes from.
    by_construction : bool
        Whether the virtual cohort was made so that they agree.
    """

    found: str
    verdict: str
    why: str
    by_construction: bool = False


def claims_table(tables: Tables) -> pd.DataFrame:
    """The main claims of the paper's sections 2 to 4 that have a number or compare two of them.

    Parameters
    ----------
    tables : mapping of DataFrame
        Tables of `make docs` by name; a claim whose tables are absent is not testable.

    Returns
    -------
    DataFrame
        `section`, `claim`, `found`, `verdict`, `by_construction`, `why`. What is alike by
        construction of the virtual cohort confirms nothing.
    """
    rows = []
    for section, claim, needed, judge in CLAIMS:
        absent = [name for name in needed if name not in tables or tables[name].empty]
        finding = (
            Finding("–", UNTESTABLE, f"without {', '.join(absent)}") if absent else judge(tables)
        )
        built = finding.by_construction
        rows.append((section, claim, finding.found, finding.verdict, built, finding.why))
    columns = ["section", "claim", "found", "verdict", "by_construction", "why"]
    return pd.DataFrame(rows, columns=columns)


def fit_errors(fits: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """`sample`, `mode`, `geometry`, `area_percent` of each test, from reports of calibrations."""
    rows = [
        (sample, mode, fit["geometry"], fit["area_error_percent"][sample])
        for fit in fits
        for sample, mode in zip(fit["samples"], fit["modes"], strict=True)
    ]
    return pd.DataFrame(rows, columns=["sample", "mode", "geometry", "area_percent"])


def _verdict(holds: bool) -> str:
    return REPRODUCED if holds else DIFFERS


def _half_interval(sds: Array, count: int) -> float:
    """Half the interval of the difference of two means over `count` samples each, by Welch."""
    squares = sds**2 / count
    freedom = squares.sum() ** 2 / (squares**2 / (count - 1)).sum()
    return float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE) * np.sqrt(squares.sum()))


def _mean(
    quantity: str, mode: str, why: str = "", by_construction: bool = False
) -> Callable[[Tables], Finding]:
    """A mean over samples.

    It is reproduced if the interval of its difference to the paper's holds zero and is no wider
    than `ALIKE` either way; a wider one that holds zero tells nothing.
    """

    def judge(tables: Tables) -> Finding:
        all_rows = tables["summary"]
        row = all_rows[(all_rows["quantity"] == quantity) & (all_rows["mode"] == mode)].iloc[0]
        (mean, papers), sds = (
            row[[f"{name}_percent", f"paper_{name}_percent"]].to_numpy(float)
            for name in ("mean", "sd")
        )
        difference, half = float(mean - papers), _half_interval(sds, int(row["count"]))
        unresolved = abs(difference) <= half and half > ALIKE
        reasons = [f"difference {signed(difference)} ± {half:.1f} points"]
        if unresolved:
            reasons.append(f"not resolved by {int(row['count'])} samples")
        if why:
            reasons.append(why)
        return Finding(
            f"{signed(mean)} % (SD {sds[0]:.1f})",
            UNTESTABLE if unresolved else _verdict(abs(difference) <= half),
            "; ".join(reasons),
            by_construction,
        )

    return judge


def _shear_bias(tables: Tables) -> Finding:
    found = _mean("modulus_two_term", "shear")(tables)
    rows = tables["bond"][tables["bond"]["mode"] == "shear"]
    depth, contact = (float(rows[f"{rule}_bias_percent"].mean()) for rule in RULES)
    summary = tables["summary"].set_index(["quantity", "mode"])
    papers = float(summary["paper_mean_percent"]["modulus_two_term", "shear"])
    between = min(depth, contact) <= papers <= max(depth, contact)
    why = (
        f"; {signed(depth)} % if what lies within the pre-load is bonded, {signed(contact)} % if "
        f"what touches in a simulated one is{'; the paper lies between' if between else ''}"
    )
    return replace(found, why=found.why + why)


def _above(other: str) -> Callable[[Tables], Finding]:
    """Whether nominal stress in compression exceeds that in another mode over most strains."""

    def judge(tables: Tables) -> Finding:
        grid = np.linspace(0.005, 0.25, 50)
        of = {
            mode: np.interp(grid, rows["strain"], rows["mean_stress_pa"])
            for mode, rows in tables["stress_strain"].groupby("mode")
        }
        share = float(np.mean(of["compression"] > of[other]))
        return Finding(
            f"so over {100.0 * share:.0f} % of the strains up to 0.25",
            _verdict(share > MOST),
            "–" if share > MOST else "incomplete contact lowers the nominal stress in compression",
        )

    return judge


def _exponents(tables: Tables) -> Finding:
    rows, common = tables["exponents"], tables["common_exponents"]
    words, every = [], True
    for name, value in (("alpha1", -8.0), ("alpha2", 16.0)):
        low, high = rows[f"{name}_low"], rows[f"{name}_high"]
        bounded = low.notna() & high.notna()
        near = (rows.loc[bounded, name] / value - 1.0).abs() <= NEAR
        held = ~(low > value) & ~(high < value)
        words.append(
            f"{name.replace('alpha', 'α')} within {100.0 * NEAR:.0f} % of {value:g} in "
            f"{int(near.sum())} of {len(near)} groups that bound it, "
            f"inside the interval in {int(held.sum())} of {len(rows)}"
        )
        every &= bool(len(near) and near.all())
    for row in common[common["mode"] == "all"].to_dict("records"):
        words.append(f"one pair for {row['groups']} groups: p = {row['p_value']:.2g}")
    return Finding(
        true_minus("; ".join(words)), _verdict(every), "one mode of loading hardly bounds α1"
    )


def _accuracy(geometry: str) -> Callable[[Tables], Finding]:
    def judge(tables: Tables) -> Finding:
        rows = tables["fit_errors"]
        errors = rows[rows["geometry"] == geometry].groupby("mode", sort=False)["area_percent"]
        ranges = [f"{mode} {part.min():.1f} to {part.max():.1f} %" for mode, part in errors]
        why = {
            "real": "the virtual records were made with these shapes",
            "ideal": "a cuboid is in full contact from the start",
        }
        return Finding(
            f"area error: {', '.join(ranges)}",
            _verdict(bool(errors.max().max() <= ACCURATE)),
            f"accurate: {ACCURATE:g} % at most; {why[geometry]}",
            by_construction=geometry == "real",
        )

    return judge


def _lower(tables: Tables) -> Finding:
    difference = tables["table1"]["difference_percent"]
    lower = int((difference < 0.0).sum())
    return Finding(
        f"lower in {lower} of {len(difference)} groups, {signed(difference.min())} to "
        f"{signed(difference.max())} %",
        _verdict(lower == len(difference)),
        "in shear the sign depends on the bonded part of the top",
    )


def _first_modulus(tables: Tables) -> Finding:
    rows = tables["table1"]
    rows = rows[rows["mode"] == AXIAL]
    changes = [
        float(np.mean(100.0 * (rows[f"{name}_ideal_pa"] / rows[f"{name}_real_pa"] - 1.0)))
        for name in ("mu1", "mu2")
    ]
    return Finding(
        f"μ1 {signed(changes[0])} %, μ2 {signed(changes[1])} % on average",
        _verdict(abs(changes[0]) > abs(changes[1])),
        "μ1 governs compression, where contact is incomplete",
    )


def _one_term(tables: Tables) -> Finding:
    rows = tables["summary"].set_index(["quantity", "mode"])["mean_percent"]
    one, two = rows["modulus_one_term", "compression"], rows["modulus_two_term", AXIAL]
    return Finding(
        f"{signed(one)} % with one term, {signed(two)} % with two",
        _verdict(abs(one - two) <= ALIKE),
        f"close: {ALIKE:g} points at most",
    )


def _lowest_in_shear(tables: Tables) -> Finding:
    rows = tables["summary"].set_index(["quantity", "mode"])["mean_percent"]
    shear, axial = (float(rows["modulus_two_term", mode]) for mode in ("shear", AXIAL))
    return Finding(
        f"{signed(shear)} % in shear, {signed(axial)} % in tension and compression",
        _verdict(abs(shear) < abs(axial)),
        "in shear the top is bonded from the start, in compression contact develops",
    )


def _growing(tables: Tables) -> Finding:
    area = tables["contact"]["real_percent"]
    return Finding(
        f"from {area.iloc[0]:.0f} to {area.iloc[-1]:.0f} % of the cuboid's section",
        _verdict(bool((area.diff().dropna() > 0.0).all())),
        "simulated contact of the real shapes",
    )


def _partial(tables: Tables) -> Finding:
    rows = tables["contact"]
    area = float(np.interp(PART_OF_TEST, rows["strain"], rows["real_percent"]))
    full = float(np.interp(PART_OF_TEST, rows["strain"], rows["ideal_percent"]))
    return Finding(
        f"at {PART_OF_TEST:g} strain {area:.0f} % of the cuboid's section touches, "
        f"against {full:.0f} % for the cuboid model",
        _verdict(area < FULL * full),
        "simulated contact of the real shapes",
    )


def _prescribed(
    geometry: str, alike: bool, at_end: bool = False, built: bool = False
) -> Callable[[Tables], Finding]:
    """Forces by prescribed displacements and by contact: alike or not, as the paper says."""

    def judge(tables: Tables) -> Finding:
        rows = tables["prescribed"]
        rows = rows[rows["geometry"] == geometry]
        apart = rows["at_end_percent" if at_end else "at_paper_strain_percent"].abs()
        strain = float(rows["end_strain" if at_end else "paper_strain"].iloc[0])
        return Finding(
            f"forces at {strain:g} strain differ by {_rounded(apart.min())} to "
            f"{_rounded(apart.max())} %",
            _verdict(bool(apart.max() <= ALIKE) == alike),
            f"alike: {ALIKE:g} % at most",
            by_construction=built,
        )

    return judge


def _mesh(tables: Tables) -> Finding:
    rows = tables["sensitivity"]
    rows = rows[rows["change"] == COARSE]
    modes = tables["fit_errors"].drop_duplicates("sample").set_index("sample")["mode"]
    change = rows["modulus_percent"].abs().groupby(rows["sample"].map(modes)).max()
    found = ", ".join(f"{mode} {value:.1f} %" for mode, value in change.items())
    return Finding(
        f"{COARSE} change a modulus by up to: {found}",
        _verdict(bool(change.max() <= INDEPENDENT)),
        f"independent: {INDEPENDENT:g} % at most; with the mesh the bonded part of the top changes",
    )


def _untestable(why: str, found: str = "–") -> Callable[[Tables], Finding]:
    return lambda tables: Finding(found, UNTESTABLE, why)


def _rounded(value: float) -> str:
    return f"{value:.0f}" if value >= 10.0 else f"{value:.2g}" if value >= 0.01 else "0.0"


RELIEF = "depends on the relief of the tops"

CLAIMS: tuple[tuple[str, str, tuple[str, ...], Callable[[Tables], Finding]], ...] = (
    ("2.4.2", "0.5 mm elements are mesh-independent", ("sensitivity", "fit_errors"), _mesh),
    ("3.1", "bottom areas differ by 6.5 % (SD 4.7)", ("summary",),
     _mean("bottom_area_absolute", "all", by_construction=True)),
    ("3.1", "top areas are 15.6 % smaller in shear (SD 2.5)", ("summary",),
     _mean("top_area", "shear", by_construction=True)),
    ("3.1", "top areas are 19.8 % smaller in tension (SD 7.5)", ("summary",),
     _mean("top_area", "tension", by_construction=True)),
    ("3.1", "top areas are 30.2 % smaller in compression (SD 4.1)", ("summary",),
     _mean("top_area", "compression", by_construction=True)),
    ("3.2", "nominal stress is higher in compression than in tension", ("stress_strain",),
     _above("tension")),
    ("3.2", "and than in shear", ("stress_strain",), _above("shear")),
    ("3.2", "free exponents are close to −8 and 16 in all samples",
     ("exponents", "common_exponents"), _exponents),
    ("3.2", "models of real geometry fit accurately", ("fit_errors",), _accuracy("real")),
    ("3.2", "models of cuboids fit accurately", ("fit_errors",), _accuracy("ideal")),
    ("3.2", "the modulus of cuboids is consistently lower", ("table1",), _lower),
    ("3.2", "by 10 % in shear (SD 6)", ("summary", "bond"), _shear_bias),
    ("3.2", "by 47.5 % in tension and compression (SD 10.9)", ("summary",),
     _mean("modulus_two_term", AXIAL, RELIEF)),
    ("3.2", "the difference is lowest in shear", ("summary",), _lowest_in_shear),
    ("3.2", "μ1 differs more than μ2 in tension and compression", ("table1",), _first_modulus),
    ("3.2", "by 48.5 % in compression with one term (SD 11)", ("summary",),
     _mean("modulus_one_term", "compression", RELIEF)),
    ("3.2", "one term in compression and two in both give nearly the same bias", ("summary",),
     _one_term),
    ("3.2", "contact is partial for a significant portion of a compression", ("contact",),
     _partial),
    ("4", "the area in contact grows in the course of a compression", ("contact",), _growing),
    ("3.2", "prescribed displacements serve on cuboids to about 15 % strain", ("prescribed",),
     _prescribed("ideal", alike=True, built=True)),
    ("3.2", "but not beyond (cited there from [15])", ("prescribed",),
     _prescribed("ideal", alike=False, at_end=True)),
    ("3.2", "and not on real geometries", ("prescribed",), _prescribed("real", alike=False)),
    ("3.2", "strain is localised and without symmetry on real geometries", (),
     _untestable("seen in the strain maps; the paper gives no number", "figure 7")),
    ("2.2, 2.3", "images, records and bonded nodes of the paper's own samples", (),
     _untestable("they are not public; the cohort is virtual")),
    ("4", "cylinders are likely to show similar effects", (),
     _untestable("the cohort has no cylinder; the workflow supports cylinders")),
)  # fmt: skip
"""Section, claim, tables it rests on, and how it is judged."""
