"""The tissue is more, or less, compressible than the model."""

from softsample.constitutive.material import Material
from softsample.loop.effects.base import SOLID, Effect, Parameter


def about(solid: Material) -> Effect:
    """The effect for a model with the Poisson's ratio of a solid."""
    nu, most = solid.poisson_ratio, 0.2 * solid.poisson_ratio + 0.8 * 0.5
    return Effect(
        name="poisson_ratio",
        title="Another Poisson's ratio",
        parameters=(Parameter("nu", "1", nu - 0.14, most, nu - 0.01, neutral=nu, limits=(most,)),),
        like_geometry=True,
        source="Hinrichsen et al., Biomech. Model. Mechanobiol. 2023, "
        "doi:10.1007/s10237-023-01739-w",
        signature="changes compression far more than tension, and tension more than shear; grows "
        "along the stroke",
        confused_with=(
            "anisotropy", "boundary_shift", "residual_precompression", "machine_compliance",
        ),
        experiment="photograph the bulge of the side walls",
        elastic=lambda specimen, fraction, travel, values: (
            specimen.elastic.ratio_change_per_mu(fraction, travel, values["nu"])
        ),
    )  # fmt: skip


EFFECT = about(SOLID)
