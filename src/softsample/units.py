"""Units that inputs, files and pages are in, in SI."""

MM = 1e-3
"""One millimetre [m]."""
