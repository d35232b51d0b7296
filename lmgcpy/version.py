"""The versions of lmgcpy and of what its numbers depend on, for all who write them into a file."""

from __future__ import annotations

import platform

VERSION = "0.2.0"


def versions() -> dict[str, str]:
    """Versions of the software on which the numbers depend; h5py and numba take long to import."""
    import h5py
    import numba
    import numpy as np

    return {
        "lmgcpy": VERSION,
        "numpy": np.__version__,
        "numba": numba.__version__,
        "h5py": h5py.__version__,
        "hdf5": h5py.version.hdf5_version,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "machine": platform.machine(),
    }
