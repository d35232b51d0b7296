"""Speed against error: problems, references, work-precision diagrams and performance profiles (``lmgcpy bench``).

Every report tells the machine: processor, versions, load.
"""

from __future__ import annotations

import os
import platform
from pathlib import Path

import numba
import numpy as np
import scipy

import lmgcpy


def machine() -> str:
    """Processor, system and versions in one line."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        lines = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        model = lines[0].split(":")[1].strip() + f", {len(lines)} cores" if lines else model
    return (
        f"{model}; {platform.system()}; Python {platform.python_version()}, numpy {np.__version__}, "
        f"scipy {scipy.__version__}, numba {numba.__version__}, lmgcpy {lmgcpy.__version__}"
    )


def load() -> str:
    """Mean number of processes that were ready to run in the last minute; "unknown" on systems without this number."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
