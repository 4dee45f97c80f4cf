"""Settings of the segmentation."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SegmentationSettings:
    """Settings of `segment`; the names and defaults of the config section `segmentation`.

    Attributes
    ----------
    fluid_brightness : float
        Expected brightness of saline over that of tissue.
    base_clearance_mm : float
        Walls lower than this above the platen (meniscus) are continued from above [mm].
    max_tilt_deg : float
        Largest tilt of the base that is taken out [degrees].
    grid_spacing_mm : float
        Spacing of the signed distance [mm].
    min_base_share : float
        Share of the underside that must lie on one plane for there to be a platen.
    min_volume_mm3 : float
        Anything smaller is not a sample [mm3].
    """

    fluid_brightness: float = 2.2
    base_clearance_mm: float = 0.75
    max_tilt_deg: float = 10.0
    grid_spacing_mm: float = 0.25
    min_base_share: float = 0.75
    min_volume_mm3: float = 100.0
