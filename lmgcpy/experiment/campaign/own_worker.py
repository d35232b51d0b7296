"""What is done to every Dask worker that a campaign begins on this machine. Imported where Dask is."""

from __future__ import annotations

import signal
import threading
from typing import Any

from distributed import WorkerPlugin


class OwnWorker(WorkerPlugin):
    """A worker without web pages, which would leave a port open, and deaf to Ctrl-C: the campaign tells its case to end."""

    name = "lmgcpy-own-worker"

    def setup(self, worker: Any) -> None:
        worker.http_server.stop()
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, signal.SIG_IGN)
