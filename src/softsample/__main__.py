"""Set up, check and run a study, and look at any result: `softsample new|add|check|run|show`."""

import argparse
import os
import re
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from softsample import __version__
from softsample.arrays import Array
from softsample.errors import InputError, SoftsampleError
from softsample.formats import IMAGE_ENDINGS, read_image
from softsample.io import (
    read_json,
    read_mesh_with_data,
    read_surface,
    read_table,
    write_text,
    written_aside,
)
from softsample.study import columns
from softsample.units import MM

KINDS = f".json, .csv, .tsv, .vtu, .stl, {', '.join(IMAGE_ENDINGS)}"
"""Files that can be shown."""

LONG = 12
"""Longer lists are abbreviated when printed."""

if TYPE_CHECKING:
    from softsample.study.check import Inspection

PROGRAM = "softsample"
"""Name of the installed command; `python -m softsample` is the same."""


CHECK_PAGE = "check.html"
"""Page that `softsample check` writes into the folder of a study."""

PIPE_CLOSED = 141
"""Exit status of a program that is stopped since nobody reads what it writes."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    given = command_line().parse_args(_joined(sys.argv[1:] if arguments is None else arguments))
    try:
        status = int(given.run(given) or 0)
        sys.stdout.flush()
        return status
    except BrokenPipeError:  # who reads has seen enough, as `| head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED
    except (SoftsampleError, OSError) as error:
        print(error, file=sys.stderr)
        return 1


def _joined(words: Sequence[str]) -> list[str]:
    """Words with an axis that begins with a dash, such as -z or -1, joined to its option."""
    found: list[str] = []
    for word in words:
        joins = found and found[-1].startswith("--") and re.fullmatch("-[xyz123]", word)
        found = [*found[:-1], f"{found[-1]}={word}"] if joins else [*found, word]
    return found


def command_line() -> argparse.ArgumentParser:
    """The commands and their options."""
    parser = argparse.ArgumentParser(prog=PROGRAM, description=__doc__)
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {__version__}")
    commands = parser.add_subparsers(required=True)
    show = commands.add_parser("show", help="print or draw a result file")
    show.add_argument("file", help=f"{KINDS} or a DICOM folder")
    show.add_argument("--segment", help="the segment to draw of a .seg.nrrd with several")
    show.add_argument("-o", "--output", help="picture to write (default: beside where you are)")
    show.add_argument("--all", action="store_true", help="print provenance and long tables too")
    show.set_defaults(run=lambda g: _show(g.file, g.output, g.all, g.segment))
    _add_study_commands(commands)
    return parser


def _add_study_commands(commands: Any) -> None:
    """Commands on a lab's own study."""
    new = commands.add_parser("new", help="make a study folder with a worked sample")
    new.set_defaults(run=lambda g: _new(g.folder))
    add = commands.add_parser("add", help="copy the files of a sample into a study, add its row")
    add.set_defaults(run=_add)
    for column, meaning in columns().items():
        option = column.removesuffix("_mm").replace("_", "-")
        # as an option a path is one from where you are
        needed, told = column in ("mode", "record"), meaning.replace(", relative to the table", "")
        add.add_argument(f"--{option}", dest=column, required=needed, help=told)
    check = commands.add_parser("check", help="tell everything that is wrong with a study")
    check.set_defaults(run=lambda g: _check(g.folder))
    for command in (new, add, check):
        command.add_argument("folder", help="of the study")
    run = commands.add_parser("run", help="run a study, to its report")
    run.set_defaults(run=_run)
    run.add_argument("folder", nargs="?", help="of the study (default: the shipped samples)")
    run.add_argument("--quick", action="store_true", help="at 1 mm, for a look in minutes")
    several = {"action": "append", "default": []}
    run.add_argument("--settings", **several, help="file of settings to use; may be repeated")
    run.add_argument("--results", help="folder of the results (default: results in the study)")
    run.add_argument("--cores", type=int, default=2, help="jobs side by side (default: 2)")
    run.add_argument("--target", **several, help="rule or file (default: all); may be repeated")


def _spoken(make: str, command: str) -> str:
    """A command as one gives it: of make in a clone, of the program `softsample` elsewhere."""
    return f"  {command if Path(sys.argv[0]).stem == PROGRAM else make}"


def _run(given: argparse.Namespace) -> int:
    from softsample.study import ROOT
    from softsample.study.run import run_study

    settings = [*([ROOT / "config/quick.yaml"] if given.quick else []), *given.settings]
    return run_study(given.folder, settings, given.results, given.target, given.cores)


def _new(folder: str) -> None:
    from softsample.study.folder import new_study

    new_study(folder)
    print(f"{folder} holds a table of samples (samples.tsv), settings (study.yaml), and a sample.")
    print("Next, add your own sample, in place of the worked one, or check what is there:")
    files = "IMAGE=scan.nii.gz RECORD=test.csv MODE=compression"
    options = "--image scan.nii.gz --record test.csv --mode compression"
    where = shlex.quote(folder)
    print(_spoken(f"make add-sample DIR={where} {files}", f"softsample add {where} {options}"))
    size = _spoken(
        "SHAPE=cylinder DIAMETER=20 HEIGHT=10", "--shape cylinder --diameter 20 --height 10"
    )
    print(f"  (without an image: {size.strip()} in its place, in mm)")
    print(_spoken(f"make check-study DIR={where}", f"softsample check {where}"))


def _add(given: argparse.Namespace) -> None:
    from softsample.study.folder import add_sample

    folder, cells = given.folder, {name: getattr(given, name) for name in columns()}
    name = add_sample(folder, {column: cell for column, cell in cells.items() if cell})
    print(f"Sample {name} is in {folder}. Next:")
    where = shlex.quote(folder)
    print(_spoken(f"make check-study DIR={where}", f"softsample check {where}"))


def _check(folder: str) -> int:
    from softsample.inspection import check_page
    from softsample.study.check import check_study

    result = check_study(folder)
    print("\n".join(result.found))
    status = _tell(result, folder)
    if result.seen:
        page = Path(folder) / CHECK_PAGE
        write_text(page, check_page(result, Path(folder).resolve().name))
        print(f"\nTo look at: {page}")
    return status


def _tell(result: "Inspection", folder: str) -> int:
    """Print doubts, faults and the next command; returns the exit status."""
    from softsample.study.check import each_cure_once

    if result.doubts:
        print(f"\nDoubts: {len(result.doubts)} (they stop nothing, but moduli may be wrong)")
        print("\n".join(f"  {doubt}" for doubt in each_cure_once(result.doubts)))
    if result.faults:
        print(f"\nFaults: {len(result.faults)}", file=sys.stderr)
        print("\n".join(f"  {fault}" for fault in each_cure_once(result.faults)), file=sys.stderr)
        return 1
    outcome = "Nothing is refused, but look at the doubts" if result.doubts else "No fault found"
    print(f"\n{outcome}; samples: {len(result.seen)}. Please compare units, signs and zero with")
    print("what the machine does. Next, for a first look in minutes (mesh of 1 mm):")
    where = shlex.quote(folder)
    make = f"make study DIR={where} CONFIG=config/quick.yaml"
    print(_spoken(make, f"softsample run {where} --quick"))
    return 0


def _show(file: str, output: str | None, everything: bool, segment: str | None) -> None:
    if not Path(file).exists():
        raise InputError(f"{file}: no such file; correct its path")
    name = Path(file).name
    stem = name if Path(file).is_dir() else name.removesuffix(".gz").rsplit(".", 1)[0]
    picture = output or f"{Path(file).parent.name}_{stem}.png"
    if name.endswith(".json"):
        data = read_json(file)
        keyed = data if isinstance(data, Mapping) else {name: data}
        print("\n".join(_lines(keyed, everything)))
    elif name.endswith((".csv", ".tsv")):
        _show_table(file, picture, everything)
    elif name.endswith(IMAGE_ENDINGS) or Path(file).is_dir():
        from softsample.figures.quicklook import slices

        data, affine = read_image(file, [segment] if segment else [])
        voxel = np.linalg.norm(affine[:3, :3], axis=0)
        print(f"{' x '.join(map(str, data.shape))} voxels")
        print(f"{' x '.join(f'{size:.4g}' for size in voxel)} mm each")
        _save(slices(data, affine, name), picture)
    elif name.endswith(".vtu"):
        _show_mesh(file, picture)
    elif name.endswith(".stl"):
        _show_surface(file, picture)
    else:
        raise InputError(f"{file}: cannot show this kind; give {KINDS} or a DICOM folder")


def _lines(data: Mapping[str, Any], everything: bool, indent: str = "") -> list[str]:
    """Keys and values, one a line; nested ones are indented."""
    lines = []
    for key, value in data.items():
        if key == "provenance" and not everything:
            continue
        if isinstance(value, Mapping):
            lines += [f"{indent}{key}:", *_lines(value, everything, indent + "  ")]
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for number, item in enumerate(value):
                lines += [f"{indent}{key}[{number}]:", *_lines(item, everything, indent + "  ")]
        elif isinstance(value, list) and len(value) > LONG and not everything:
            lines.append(f"{indent}{key}: {value[:LONG]} ... ({len(value)} values)")
        else:
            lines.append(f"{indent}{key}: {value}")
    return lines


def _show_table(file: str, picture: str, everything: bool) -> None:
    table = read_table(file)
    print(table.to_string(max_rows=None if everything else 20, index=False))
    if "displacement_mm" in table:
        from softsample.figures.quicklook import curves

        _save(curves(table, str(Path(*Path(file).parts[-3:]))), picture)


def _show_surface(file: str, picture: str) -> None:
    surface = read_surface(file)
    low, high = (f(surface.points, axis=0) / MM for f in (np.min, np.max))
    print(f"{len(surface.triangles)} triangles around {surface.volume / MM**3:.6g} mm3")
    for axis in range(3):
        print(f"{'xyz'[axis]}: {low[axis]:.4g} to {high[axis]:.4g} mm")
    _draw(file, picture, surface.points[surface.triangles])


def _show_mesh(file: str, picture: str) -> None:
    mesh, point_data, cell_data = read_mesh_with_data(file)
    print(f"{len(mesh.hexes)} elements, {len(mesh.points)} nodes")
    for kind, arrays in (("node", point_data), ("element", cell_data)):
        for name, values in arrays.items():
            print(f"{kind} data {name}: {values.min():g} to {values.max():g}")
    first = next(iter(cell_data), None)
    colours = None if first is None else cell_data[first][mesh.boundary_owners]
    _draw(file, picture, mesh.points[mesh.boundary_quads], first, colours)


def _draw(
    file: str,
    picture: str,
    corners: Array,
    name: str | None = None,
    values: NDArray[Any] | None = None,
) -> None:
    """Picture of a mesh file by VTK, or of its faces (n, k, 3) [m] where VTK cannot draw."""
    from softsample.figures.offscreen import ADVICE, rendering_works
    from softsample.figures.quicklook import faces, render

    if rendering_works():
        from matplotlib.image import imsave

        image = render(file, name)
        with written_aside(picture) as aside:
            imsave(aside, image)
        print(f"picture: {picture}")
    else:
        print(ADVICE, file=sys.stderr)
        _save(faces(corners, Path(file).name, name, values), picture)


def _save(figure: Any, picture: str) -> None:
    with written_aside(picture) as aside:
        figure.savefig(aside, dpi=150)
    print(f"picture: {picture}")


if __name__ == "__main__":
    sys.exit(main())
