"""The work of one case, in the worker that does it."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.errors import number, numbers, shown
from lmgcpy.errors import told as in_text
from lmgcpy.experiment.campaign.cases import FAILED, FINISHED, TO_COME, CampaignCase, CaseResult, is_text
from lmgcpy.experiment.study.engine import Site, Study, carry_out_study
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.study.stages import ToldStages
from lmgcpy.version import versions


@dataclass(frozen=True)
class Order:
    """An order for a worker: a case, and the campaign to which it belongs."""

    case: CampaignCase
    campaign: str
    """Folder of the campaign, as the one who ordered sees it."""
    site: Site
    """The site of the campaign, which tells the case to end."""
    versions: dict[str, str]
    """Of the one who ordered."""

    @property
    def progress_file(self) -> Path:
        """File into which the case writes how far it is."""
        return Path(self.campaign) / "cases" / f"{self.case.name}.progress"


def do_case(order: Order) -> CaseResult:
    """Do a case; errors are in the result. The status is "to come" where the campaign was stopped before the end.

    Runs are recorded in the case's folder and go on from there, if the worker sees the folder of the campaign.
    """
    case, here = order.case, versions()
    begin = clock.perf_counter()

    def made(status: str, error: str = "", numbers: Any = None, curves: Any = None) -> CaseResult:
        seconds = clock.perf_counter() - begin
        error = error.encode("utf-8", "backslashreplace").decode()  # as files and terminals can hold it
        return CaseResult(case.name, case.parameters, status, seconds, error, numbers or {}, curves or {}, here)

    if here["lmgcpy"] != order.versions["lmgcpy"]:
        have = f"The worker has lmgcpy {here['lmgcpy']}, the campaign {order.versions['lmgcpy']}"
        return made(FAILED, f"{have}: install the same version there.")
    campaign = Path(order.campaign)
    seen = (campaign / "campaign.json").exists()
    folder = campaign / "cases" / case.name if seen else None
    told = ToldStages(order.progress_file if seen else None)
    if order.site.interrupted():
        return made(TO_COME)
    try:
        numbers, curves = _computed(case, folder, told, order.site)
    except KeyboardInterrupt:
        return made(TO_COME) if order.site.interrupted() else made(FAILED, "KeyboardInterrupt: the case raised it itself.")
    except SystemExit as error:
        return made(FAILED, f"SystemExit: the case called sys.exit({in_text(error.code)}).")
    except (Exception, GeneratorExit) as error:
        return made(FAILED, f"{type(error).__name__}: {in_text(error, str)}")
    finally:
        told.end()
    return made(FINISHED, "", numbers, curves)


def _computed(
    case: CampaignCase, folder: Path | None, told: ToldStages, campaign: Site
) -> tuple[dict[str, float], dict[str, Any]]:
    """Numbers and curves of a case."""
    if isinstance(case.work, Study):
        kept = None if folder is None else StudyFolder(folder, type(case.work))
        resume = kept is not None and _holds(kept, case.work)
        result = carry_out_study(case.work, told, kept, resume=resume, outer=campaign)
        return case.work.measures(result)
    if folder is not None:
        folder.mkdir(exist_ok=True)
    site = Site(told, folder, campaign)
    with site.listening():
        return as_result(case.work(site, **case.arguments), case.work.__name__)


def _holds(folder: StudyFolder, study: Study) -> bool:
    """Whether a folder holds this study, from which it goes on; one that is damaged is begun anew."""
    try:
        return folder.study_file.exists() and folder.read() == study
    except ValueError:
        return False


def as_result(given: Any, name: str) -> tuple[dict[str, float], dict[str, Any]]:
    """Numbers and curves in the result of a function; TypeError or ValueError with a sentence."""
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise TypeError(f"{name} must return numbers and arrays by name, got {shown(given)}.")
    for key in given:
        if not is_text(key):
            raise ValueError(f"{name} returned a result under the name {shown(key)}, which no file can hold.")
    single: dict[str, float] = {}
    columns: dict[str, np.ndarray] = {}
    for key, value in given.items():
        if np.ndim(value) == 0:
            single[key] = number(value, f"'{key}' that {name} returned")
        else:
            columns[key] = numbers(value, f"'{key}' that {name} returned")
            if columns[key].ndim != 1:
                raise ValueError(f"'{key}' that {name} returned must be a number or a column, got shape {np.shape(value)}.")
    if len({len(column) for column in columns.values()}) > 1:
        lengths = ", ".join(f"'{key}' {len(column)}" for key, column in columns.items())
        raise ValueError(f"The columns that {name} returned must be of one length, got {lengths}.")
    return single, {"": columns} if columns else {}
