"""One solver process for `benchmarks/solver.py`; prints one number.

With `start` CPU seconds from nothing to the end of a tiny run, with `memory` the peak memory [MB]
and with `rate` the element-steps per CPU second of 47,840 elements.
"""

import re
import sys
import time
from pathlib import Path

from case import MATERIAL, TRAVEL, boundary_of, cuboid, rates
from softsample.fem.explicit import ExplicitModel, SolverSettings


def start() -> float:
    """CPU seconds of this process up to the end of a run of 156 elements."""
    _run(4e-3, 1e-3)
    return time.process_time()


def memory() -> float:
    """Peak resident memory [MB] of a run of 47,840 elements."""
    _run(0.5e-3, 2e-3)
    # not ru_maxrss, which a process inherits from the one that started it
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024.0


def rate() -> float:
    """Element-steps per CPU second at 47,840 elements, even exponents, single precision."""
    return rates(0.5e-3, "float32", repeats=60)["element_steps_per_cpu_s"]


def _run(size: float, loading_time: float) -> None:
    mesh = cuboid(size)
    model = ExplicitModel(mesh, SolverSettings())
    travel = 0.1 * TRAVEL["tension"]
    model.run(MATERIAL, boundary_of(mesh, "tension"), travel, loading_time=loading_time)


if __name__ == "__main__":
    print({"start": start, "memory": memory, "rate": rate}[sys.argv[1]]())
