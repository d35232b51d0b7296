"""Dask's workers without their web pages, which would leave a port open. Imported where Dask is."""

from __future__ import annotations

from typing import Any

from distributed import WorkerPlugin


class NoPages(WorkerPlugin):
    """Closes the pages of every worker that begins."""

    name = "lmgcpy-no-pages"

    def setup(self, worker: Any) -> None:
        worker.http_server.stop()
