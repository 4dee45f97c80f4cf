"""Named errors of the package: each message says what is wrong, where, and how to cure it."""

from collections.abc import Mapping
from typing import Any

import yaml


class SoftsampleError(ValueError):
    """Base of all errors that a user can cure."""


class InputError(SoftsampleError):
    """A table, record, image or configuration is wrong."""


class SegmentationError(SoftsampleError):
    """The sample cannot be told from its surroundings in the image."""


class MeshError(SoftsampleError):
    """No valid hexahedral mesh could be made of the geometry."""


class SimulationError(SoftsampleError):
    """A finite element run became invalid (inverted element, unstable step, energy error)."""


class TooFarError(SimulationError):
    """The displacement is too large for the mesh; a smaller one may come through."""


class CrushedError(TooFarError):
    """Elements invert, or are so flat that the stable step vanishes."""


class CalibrationError(SoftsampleError):
    """The parameters cannot be identified from the given curves."""


def records_setting(keys: Mapping[str, Any], block: str = "") -> str:
    """Settings of records, or of a block of `formats`, as a line to paste into study.yaml."""
    section = {"formats": {block: dict(keys)}} if block else {"records": dict(keys)}
    return as_setting(section)


def as_setting(section: Mapping[str, Any]) -> str:
    """A section of the settings in one line of YAML, marked as code."""
    text = yaml.safe_dump(
        dict(section), default_flow_style=True, allow_unicode=True, width=10**6, sort_keys=False
    )
    return f"`{text.strip()[1:-1]}`"
