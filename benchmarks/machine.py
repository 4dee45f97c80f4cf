"""What one core of this machine can do: multiply-adds in registers, memory bandwidth."""

import platform
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np

from softsample.fem.lanes import LANES, load, store


def best_cpu_seconds(work: Callable[[], object], repeats: int) -> float:
    """Smallest CPU time [s] of several calls; others on the machine only ever add to it."""
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return min(seconds)


CHAINS = 16
"""Independent sums in registers: twice what two units of four cycles need to be kept busy."""


@numba.njit(forceinline=True)
def _four_loads(array, k):  # noqa: ANN001, ANN202 (Numba infers types)
    return (
        load(array, (k,), None), load(array, (k + 1,), None),
        load(array, (k + 2,), None), load(array, (k + 3,), None),
    )  # fmt: skip


@numba.njit(forceinline=True)
def _four(s, x, y):  # noqa: ANN001, ANN202
    return s[0] * x + y, s[1] * x + y, s[2] * x + y, s[3] * x + y


@numba.njit
def _multiply_add(array, repeats):  # noqa: ANN001, ANN202
    """`repeats` fused multiply-adds on each of sixteen different vectors, rows of `array`."""
    x, y = load(array, (CHAINS,), None), load(array, (CHAINS + 1,), None)
    p, q = _four_loads(array, 0), _four_loads(array, 4)
    r, s = _four_loads(array, 8), _four_loads(array, 12)
    for _ in range(repeats):
        p, q, r, s = _four(p, x, y), _four(q, x, y), _four(r, x, y), _four(s, x, y)
    total = (p[0] + p[1] + p[2] + p[3]) + (q[0] + q[1] + q[2] + q[3])
    total = total + (r[0] + r[1] + r[2] + r[3]) + (s[0] + s[1] + s[2] + s[3])
    store(array, (0,), None, total)


def fma_peak_gflops(precision: str) -> float:
    """Floating-point operations per CPU nanosecond of one thread that only multiplies and adds."""
    dtype = np.dtype(precision)
    array = np.random.default_rng(0).random((CHAINS + 2, LANES[dtype])).astype(dtype)
    repeats = 2_000_000
    _multiply_add(array, 1)
    seconds = best_cpu_seconds(lambda: _multiply_add(array, repeats), 5)
    return 2.0 * CHAINS * LANES[dtype] * repeats / seconds / 1e9


def stream_gb_s(megabytes: int = 1024) -> dict[str, float]:
    """Bytes read and written per CPU nanosecond by NumPy's copy and sum of three big arrays."""
    a, b, c = (np.full(megabytes * 2**20 // 8, float(k)) for k in range(3))
    seconds = {
        "copy": best_cpu_seconds(lambda: np.copyto(a, b), 3) / 2,
        "add": best_cpu_seconds(lambda: np.add(a, b, out=c), 3) / 3,
    }
    return {name: a.nbytes / value / 1e9 for name, value in seconds.items()}


def processor() -> str:
    """Name of the processor, as far as the system tells."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or "unknown"
    names = [line.split(":")[1].strip() for line in text.splitlines() if "model name" in line]
    return names[0] if names else platform.machine()
