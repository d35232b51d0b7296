"""Processes that begin where Python has imported lmgcpy: a sweep of them costs a tenth of as many new ones.

Run as a script, it reads requests, forks for each and prints its exit code.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import traceback
from pathlib import Path


class Forks:
    """A process that has imported lmgcpy and compiled no kernel; each :meth:`run` is a copy of it."""

    def __init__(self):
        path = os.pathsep.join(entry for entry in sys.path if entry)
        environment = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
        self.process = subprocess.Popen([sys.executable, __file__], env=environment, stdin=-1, stdout=-1, text=True)

    def run(self, code: str, folder: Path, **variables: object) -> tuple[str, str]:
        """What a script prints and its errors; it looks in ``folder`` first for modules, and may not fail."""
        out, err = folder / "out", folder / "err"
        words = {name: str(value) for name, value in variables.items()}
        request = {"code": code, "folder": str(folder), "out": str(out), "err": str(err), "variables": words}
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        status = self.process.stdout.readline()
        assert status == "0\n", err.read_text()
        return out.read_text(), err.read_text()

    def close(self) -> None:
        self.process.communicate()


def serve() -> None:
    """Answer the requests of standard input until it ends."""
    import numba

    import lmgcpy.compiled.kernel  # noqa: F401

    numba.njit(lambda x: x + 1.0)(1.0)  # what numba prepares for its first function takes a second
    for line in sys.stdin:
        request = json.loads(line)
        child = os.fork()
        if child == 0:
            os._exit(answer(request))
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def answer(request: dict) -> int:
    """Run one script in this process; its exit code."""
    for name, descriptor in (("out", 1), ("err", 2)):
        with open(request[name], "w") as file:
            os.dup2(file.fileno(), descriptor)
    os.environ.update(request["variables"])
    sys.path.insert(0, request["folder"])
    try:
        exec(request["code"], {"__name__": "__main__"})
        return 0
    except BaseException:
        traceback.print_exc()
        return 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()


if __name__ == "__main__":
    serve()
