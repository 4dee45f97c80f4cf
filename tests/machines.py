"""Test records as machines write them, with made-up numbers (no code under test)."""

import numpy as np

GRAVITY, POUND = 9.80665, 4.4482216152605


def compression(seed=0, rest=0.5, travel=-2.0, speed=0.3, peak=-0.9, step=0.02):
    """Time [s], travel [mm], force [N] of a rest and a ramp, tension positive, to five digits."""
    time = np.round(np.arange(0.0, rest + abs(travel) / speed, step), 2)
    moved = np.sign(travel) * speed * np.clip(time - rest, 0.0, None)
    noise = np.random.default_rng(seed).normal(size=(2, len(time)))
    force = peak * (moved / travel) ** 2 + 1e-3 * noise[1]
    return time, np.round(moved + 1e-3 * noise[0], 4), np.round(force, 5)


def univert(time, travel, force):
    """CellScale UniVert: one line of titles with units; the size is that of the sample."""
    cycles = np.where(np.arange(len(time)) < 25, "1-Hold", "1-Compress")
    lines = [
        f"test,{cycle},{t:.2f},{13.0 + d:.4f},{d:.4f},{f:.5f}"
        for cycle, t, d, f in zip(cycles, time, travel, force, strict=True)
    ]
    return "\n".join(["SetName,Cycle,Time_S,Size_mm,Displacement_mm,Force_N", *lines, ""])


def bluehill(time, travel, force):
    """Instron Bluehill raw data, English: dimensions, a blank line, titles, units in brackets."""
    rows = [
        f'"{t:.2f}","{d:.4f}","{f / 1e3:.8f}"' for t, d, f in zip(time, travel, force, strict=True)
    ]
    head = ["Dimension : Width,20,mm", "Dimension : Length,23,mm", ""]
    return "\r\n".join([*head, "Time,Extension,Load", "(s),(mm),(kN)", *rows, ""])


def bluehill_german(time, travel, force):
    """The same with decimal commas, semicolons, German titles, pounds, in Windows-1252."""
    rows = [
        ";".join(f'"{x:.{n}f}"'.replace(".", ",") for x, n in ((t, 2), (d, 4), (f / POUND, 7)))
        for t, d, f in zip(time, travel, force, strict=True)
    ]
    text = "\r\n".join(['"Zeit";"Verlängerung";"Kraft"', '"(s)";"(mm)";"(lbf)"', *rows, ""])
    return text.encode("cp1252")


def wintest(time, travel, force):
    """TA/Bose WinTest: metadata, trailing commas, blocks with titles of their own, NUL."""
    rows = [f"{t:.2f},{d:.4f},{f:.5f},,\r\n" for t, d, f in zip(time, travel, force, strict=True)]
    titles = "Elapsed Time,Disp,Load 1,,\r\nSec,mm,N,,\r\n"
    half = len(rows) // 2
    blocks = (rows[:half], rows[half:])
    parts = [f"Points,{len(block)},,,\r\n{titles}{''.join(block)}\r\n" for block in blocks]
    head = "WinTest 7 Data File,,,,\r\nOperator: made up,,,,\r\n\r\n"
    return (head + "".join(parts) + "\0" * 12).encode()


def grams(time, travel, force):
    """A table of another machine: compression positive, grams, micrometres, milliseconds, tabs."""
    rows = [
        f"{1e3 * t:.0f}\t{-1e3 * d:.1f}\t{-1e3 * f / GRAVITY:.6f}"
        for t, d, f in zip(time, travel, force, strict=True)
    ]
    return "\n".join(["Time [ms]\tCompression [µm]\tCompressive load [g]", *rows, ""])


MACHINES = {
    "CellScale UniVert": univert,
    "Instron Bluehill": bluehill,
    "German Bluehill": bluehill_german,
    "TA/Bose WinTest": wintest,
    "table": grams,
}


def write(path, content):
    """Write text (UTF-8) or bytes; returns the path."""
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path
