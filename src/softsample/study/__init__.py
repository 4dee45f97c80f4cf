"""A lab's own study: its folder, and everything that is wrong with it."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
"""The checkout, which holds configuration, schemas and the worked sample."""

TABLE, SETTINGS = "samples.tsv", "study.yaml"
"""Files of a study folder."""
