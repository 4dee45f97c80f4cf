"""Fixtures shared by all tests: small meshes and the material of the reference curves."""

import os
from pathlib import Path

import numpy as np
import pytest

from softsample.dependencies import state_of_kernels

ROOT = Path(__file__).resolve().parent.parent
# an edit of one file of compiled code would not be seen in another: one cache for each state
os.environ.setdefault("NUMBA_CACHE_DIR", str(ROOT / ".numba" / state_of_kernels(ROOT / "src")))

from softsample.constitutive.ogden import OgdenMaterial
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh


def pytest_configure(config):
    config.addinivalue_line(
        "markers", "nojit: short enough to run with NUMBA_DISABLE_JIT=1 too (pytest -m nojit)"
    )


@pytest.fixture(scope="session")
def tissue():
    """Two terms with the exponents of the study, moduli of the reference curves [Pa]."""
    return OgdenMaterial((1196.8, 113.1), (-8.0, 16.0), 0.49)


@pytest.fixture(scope="session")
def block():
    """36 regular elements of about 1 mm, 4 x 3 x 3: two full blocks of lanes and a bit."""
    return mesh_cuboid(4e-3, 3.3e-3, 2.7e-3, 1e-3)


@pytest.fixture(scope="session")
def crooked(block):
    """The block with all nodes off the base plane moved at random by up to 0.15 mm."""
    shift = np.random.default_rng(3).uniform(-1.5e-4, 1.5e-4, block.points.shape)
    return HexMesh(block.points + shift * (block.points[:, 2:] > 0.0), block.hexes)
