"""Processes that begin where Python has imported lmgcpy: a sweep of them costs a tenth of as many new ones.

Run as a script, it reads requests, forks for each and prints its exit code.
"""

from __future__ import annotations

import atexit
import json
import os
import signal
import subprocess
import sys
import tempfile
import traceback
import warnings
from functools import cache
from pathlib import Path

from soft_law import process

LONGEST = 300
"""A copy that takes longer is ended, with the exit code -SIGALRM [s]."""


def forked(
    code: str, *arguments: object, folder: Path | None = None, strict: bool = True, check: bool = True, **variables: object
) -> subprocess.CompletedProcess:
    """A copy of a process that has imported lmgcpy and loaded no kernel, when it has run a script; see :func:`process`.

    It runs in ``folder``. Where processes cannot be copied it is a new one.
    """
    if not hasattr(os, "fork"):
        return process(code, *arguments, folder=folder, strict=strict, check=check, **variables)
    with tempfile.TemporaryDirectory() as here:
        out, err = Path(here) / "out", Path(here) / "err"
        request = {
            "code": code,
            "arguments": [str(argument) for argument in arguments],
            "folder": str(folder or here),
            "strict": strict,
            "out": str(out),
            "err": str(err),
            "variables": {**os.environ, **{name: str(value) for name, value in variables.items()}},
        }
        status = server().ask(request)
        done = subprocess.CompletedProcess(["python", "-c", code], status, out.read_text(), err.read_text())
    assert not check or done.returncode == 0, done.stderr
    return done


class Server:
    """The process that is copied."""

    def __init__(self):
        path = os.pathsep.join(entry for entry in sys.path if entry)
        environment = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
        self.process = subprocess.Popen([sys.executable, __file__], env=environment, stdin=-1, stdout=-1, text=True)
        atexit.register(self.process.communicate)

    def ask(self, request: dict) -> int:
        """The exit code of the copy that a request is given to."""
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        return int(self.process.stdout.readline())


server = cache(Server)


def serve() -> None:
    """Answer the requests of standard input until it ends."""
    import h5py  # noqa: F401
    import matplotlib.pyplot  # noqa: F401
    import numba
    import scipy.sparse  # noqa: F401

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
    signal.alarm(LONGEST)
    for name, descriptor in (("out", 1), ("err", 2)):
        with open(request[name], "w") as file:
            os.dup2(file.fileno(), descriptor)
    os.environ.clear()
    os.environ.update(request["variables"])
    os.chdir(request["folder"])
    sys.path.insert(0, request["folder"])
    sys.argv = ["-c", *request["arguments"]]
    warnings.simplefilter("error" if request["strict"] else "default")
    try:
        exec(request["code"], {"__name__": "__main__"})
        return 0
    except SystemExit as end:
        return end.code or 0
    except BaseException:
        traceback.print_exc()
        return 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()


if __name__ == "__main__":
    serve()
