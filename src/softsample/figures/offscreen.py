"""Can VTK draw without a screen here? Asked in a process of its own, since VTK may crash."""

import subprocess
import sys
from functools import cache

ADVICE = (
    "VTK cannot draw off-screen on this machine, so meshes are drawn with matplotlib. For rendered "
    "pictures install two libraries, on Debian or Ubuntu: apt-get install libegl1 libgl1-mesa-dri"
)
"""What to tell the user when `rendering_works` is false."""

PROBE = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
plotter.add_mesh(pyvista.Cube())
raise SystemExit(0 if plotter.screenshot(return_img=True).std() > 0 else 1)
"""


@cache
def rendering_works(timeout_s: float = 120.0) -> bool:
    """Whether a picture could be rendered off-screen; without libraries VTK ends in SIGSEGV."""
    try:
        probe = subprocess.run(
            [sys.executable, "-c", PROBE], capture_output=True, timeout=timeout_s, check=False
        )
    except subprocess.TimeoutExpired:
        return False
    return probe.returncode == 0
