"""Figures: each function returns a figure and saves nothing."""
