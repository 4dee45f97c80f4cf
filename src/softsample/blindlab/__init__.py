"""Blind laboratory: records with undeclared effects, and the score of what the loop says of them.

Whatever makes records (`bodies`, `curves`, `faults`, `records`, `plan`) imports nothing of
`softsample.loop`; `judge` hands the loop its own model and the bare records. The effect library is
imported nowhere here: the formulas, the spectrum of relaxation, the clock and the mesh are others.
"""
