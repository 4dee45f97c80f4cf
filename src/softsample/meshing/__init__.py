"""Hexahedral meshes of real and idealised samples, and their quality."""
