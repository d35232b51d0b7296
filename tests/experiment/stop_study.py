"""The command ``lmgcpy`` in a process that sends itself a signal: ``stop_study.py SIGNAL RUN STEP ARGUMENTS...``.

The signal comes when the run file of that name has got the row of that step. Every step is written at once.
"""

import os
import signal
import sys

from lmgcpy.cli import main
from lmgcpy.experiment import recorded_run
from lmgcpy.io.recorder import RunRecorder


def stop_at(number: signal.Signals, name: str, step: int) -> None:
    enter = RunRecorder.enter

    def enter_and_stop(self, sim):
        enter(self, sim)
        if os.path.basename(self.path) == f"{name}.h5" and sim.steps == step:
            os.kill(os.getpid(), number)

    RunRecorder.enter = enter_and_stop
    recorded_run.FLUSH = 0.0


if __name__ == "__main__":
    word, name, step, *arguments = sys.argv[1:]
    stop_at(signal.Signals[word], name, int(step))
    main(arguments)
