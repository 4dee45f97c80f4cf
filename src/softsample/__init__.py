"""Shear modulus of very soft tissue from an image and a force record, on real geometry."""

__version__ = "0.1.0"
