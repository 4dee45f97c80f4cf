"""Phantom laboratory: shapes of known surface, and their magnetic resonance images.

Lengths are in mm and directions in the shape's own frame unless said otherwise: base on z = 0,
loading axis +z. The package judges the segmentation, and imports nothing that segments.
"""
