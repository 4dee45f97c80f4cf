"""Named errors of the package: each message says what is wrong, where, and how to cure it."""


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


class CrushedError(SimulationError):
    """Elements invert, or are so flat that the stable step vanishes."""


class CalibrationError(SoftsampleError):
    """The parameters cannot be identified from the given curves."""
