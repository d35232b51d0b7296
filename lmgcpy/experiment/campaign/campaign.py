"""A campaign as a user has it: its description, and the call that carries it out."""

from __future__ import annotations

import inspect
import os
from dataclasses import dataclass
from typing import Any

from lmgcpy.errors import named_arguments
from lmgcpy.experiment.campaign.carry_out import carry_out
from lmgcpy.experiment.campaign.description import CampaignDescription
from lmgcpy.experiment.campaign.results import CampaignResults


@named_arguments
@dataclass(frozen=True, repr=False)
class Campaign(CampaignDescription):
    """Many cases of one computation, which are independent of each other.

    ``work`` is a study, such as ``Study3D(grain_count=800)``, or a function ``work(site, **parameters)`` of a module. It
    returns a mapping: numbers by name, with the unit at the end of the name, as "strength [Pa]", and arrays of one length,
    the columns of a curve. ``site.run(name, label, steps, call, ...)`` gives a run of it a file from which it goes on, as
    in a study.

    ``over`` gives lists of values by parameter, all of whose combinations are cases, the last parameter changing fastest;
    ``cases`` lists further ones, each a mapping; ``fixed`` gives parameters that all cases have.

    ``case_timeout``: a case that takes longer [s] is killed and has failed, None for no such limit. Each case is then done
    in a process of its own, whose start, a few seconds, counts. It is no part of what the campaign computes: a campaign may
    go on with another one.

    Raises TypeError and ValueError with a sentence if the work has no such parameter, or if there is no case, or one twice.
    """

    def __repr__(self) -> str:
        of = self.work.__name__ if inspect.isfunction(self.work) else type(self.work).__name__
        return f"<Campaign of {len(self.all_cases())} cases of {of}>"

    def run(
        self,
        out: str | os.PathLike,
        *,
        workers: int | None = None,
        client: Any = None,
        resume: bool = False,
        force: bool = False,
        progress: bool = False,
    ) -> CampaignResults:
        """Carry the campaign out in the folder ``out`` and return its results.

        The cases go to ``workers`` processes of this machine, by default as many as it has processors, or to the Dask
        cluster of a ``client``. A case that fails is recorded with its error; one whose worker dies is done again.
        ``resume`` goes on with the cases in the folder, and tries again those that failed; ``force`` writes into a folder
        that is not empty; ``progress`` shows the running cases on a terminal.

        Ctrl-C (KeyboardInterrupt) ends the runs between two steps. Raises FileExistsError, FileNotFoundError, ValueError or
        BlockingIOError if the folder is not fit for it, and RuntimeError if workers have another version of lmgcpy.
        """
        options = {"workers": workers, "client": client, "resume": resume, "force": force, "progress": progress}
        return carry_out(self, out, **options)
