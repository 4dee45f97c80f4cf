"""docs/accuracy.md and its figure from results/bench/imaging.json, which imaging.py writes."""

import json
import sys
from pathlib import Path
from typing import Any

import jinja2
import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from imaging import (
    SWEEPS,
    Record,
    coverage,
    halves,
    mesh_bars,
    surface_bars,
    verdicts,
)
from softsample.figures.style import PALETTE, page_figure, save, styled
from softsample.io import write_text

ROOT = Path(__file__).parents[1]
FIGURE = ROOT / "docs" / "figures" / "imaging_accuracy.png"
AXES = {
    "snr": ("snr", "signal to noise ratio"),
    "voxel": ("voxel_mm", "voxel edge [mm]"),
    "film": ("film_mm", "film [mm]"),
}
LABELS = {
    "dice": "Dice coefficient",
    "volume_error_percent": "volume error [%]",
    "mean_distance_mm": "mean distance of the surfaces [mm]",
    "p95_distance_mm": "95 % of the distances below [mm]",
    "edge_error_mm": "largest error of the cuboid's edges [mm]",
    "tilt_error_deg": "tilt of the base [°]",
    "min_scaled_jacobian": "smallest scaled Jacobian",
    "p1_scaled_jacobian": "1 % quantile of the scaled Jacobian",
    "min_edge_over_h": "shortest edge over h",
    "fb_length_over_h": "Flanagan-Belytschko length over h",
    "mesh_volume_percent": "volume against the surface's [%]",
    "mesh_distance_mm": "mean distance to the surface [mm]",
    "mesh_cpu_s": "CPU [s]",
}


@styled
def draw(sweeps: dict[str, list[Record]]) -> Figure:
    """Error and stated sigma over noise, voxel size and film."""
    figure = page_figure(70.0)
    axes = figure.subplots(1, 3, sharey=True)
    for axis, (name, (key, label)) in zip(axes, AXES.items(), strict=True):
        records = [record for record in sweeps[name] if record["status"] == "ok"]
        films = sorted({r["film_mm"] for r in records}) if name != "film" else [None]
        for film, colour in zip(films, PALETTE, strict=False):
            chosen = [r for r in records if film in (None, r["film_mm"])]
            _curves(axis, chosen, key, colour, "" if film is None else f", film {film:g} mm")
        axis.set(xlabel=label, yscale="log")
        if name != "film":
            axis.set_xscale("log")
            places = [round(value, 2) for value in SWEEPS[name][0]]
            axis.set_xticks(places, [f"{value:g}" for value in places])
            axis.set_xticks([], minor=True)
        axis.legend()
    axes[0].set_ylabel("distance from the true surface [mm]")
    return save(figure, FIGURE, 160)


def _curves(axis: Any, records: list[Record], key: str, colour: str, label: str) -> None:
    """Phantoms as dots, their mean as a line, the mean of the stated sigma dashed."""
    x = np.array([r[key] for r in records])
    values = np.unique(x)
    for name, style, text in (("mean_distance_mm", "-", "error"), ("sigma_mm", "--", "stated")):
        y = np.array([r[name] for r in records])
        means = [y[x == value].mean() for value in values]
        axis.plot(values, means, style, color=colour, label=text + label)
        if style == "-":
            axis.plot(x, y, ".", color=colour, alpha=0.6)


def render(found: dict[str, Any]) -> None:
    """docs/accuracy.md from its template."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent), undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    phantoms, stress = found["phantoms"], found["stress_meshes"]
    text = environment.get_template("imaging.md.j2").render(
        phantoms=phantoms,
        stress=stress,
        sweeps=found["sweeps"],
        versions=found["versions"],
        labels=LABELS,
        pooled=verdicts(phantoms, surface_bars),
        halves={
            name: {v.name: v for v in verdicts(records, surface_bars)}
            for name, records in halves(phantoms).items()
        },
        coverage={
            "pooled": coverage(phantoms),
            **{name: coverage(records) for name, records in halves(phantoms).items()},
        },
        meshes=verdicts(phantoms, mesh_bars),
        stressed={verdict.name: verdict for verdict in verdicts(stress, mesh_bars)},
        segment_cpu_s=np.array([r["segment_cpu_s"] for r in phantoms]),
        unseen=[
            r
            for r in phantoms
            if r["status"] == "ok" and r["film_mm"] > 0.0 and r["film_found_mm"] == 0.0
        ],
        invented=[
            r
            for r in phantoms
            if r["status"] == "ok" and r["film_mm"] == 0.0 and r["film_found_mm"] > 0.0
        ],
    )
    write_text(ROOT / "docs" / "accuracy.md", text)


def main(source: str = "results/bench/imaging.json") -> None:
    """Figure and page."""
    mpl.use("Agg")
    found = json.loads(Path(source).read_text(encoding="utf-8"))
    draw(found["sweeps"])
    render(found)


if __name__ == "__main__":
    main(*sys.argv[1:])
