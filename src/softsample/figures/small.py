"""Smaller copies of figures, for pages that are kept under version control."""

from pathlib import Path

from PIL import Image

WIDTH = 1100
"""Width in pixels, enough for a page on a screen."""


def shrink(source: Path, target: Path) -> None:
    """Write a PNG again, at most `WIDTH` pixels wide and with 128 colours."""
    with Image.open(source) as image:
        picture = image.convert("RGB")
    if picture.width > WIDTH:
        height = round(picture.height * WIDTH / picture.width)
        picture = picture.resize((WIDTH, height), Image.Resampling.LANCZOS)
    colours = picture.quantize(128, dither=Image.Dither.NONE)
    colours.save(target, format="PNG", optimize=True)
