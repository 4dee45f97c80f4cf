"""Smaller copies of figures, for pages that are kept under version control."""

from pathlib import Path

from PIL import Image

from softsample.files import written_aside

WIDTH = 1100
"""Width in pixels, enough for a page on a screen."""


def shrink(source: Path, target: Path) -> None:
    """Write a PNG again, whole or not at all, at most `WIDTH` pixels wide and with 128 colours."""
    with Image.open(source) as image:
        picture = image.convert("RGB")
    if picture.width > WIDTH:
        height = round(picture.height * WIDTH / picture.width)
        picture = picture.resize((WIDTH, height), Image.Resampling.LANCZOS)
    colours = picture.quantize(128, dither=Image.Dither.NONE)
    with written_aside(target) as aside:
        colours.save(aside, format="PNG", optimize=True)
