"""A campaign in a TOML file.

    study = "texsol-3d"            # or "texsol", "column", or "module:function" of one's own
    case_timeout = 3600            # a case that takes longer is killed and has failed [s]; no limit without it

    [fixed]                        # parameters of all cases
    grain_count = 800

    [over]                         # all combinations of these
    bead_count = [0, 200, 400]
    axes = ["z", "x"]
    seed = [0, 1, 2, 3, 4]

    [[cases]]                      # further ones, one by one
    bead_count = 800
"""

from __future__ import annotations

import os
import sys
import tomllib
from pathlib import Path
from typing import Any

from lmgcpy.errors import closest, shown
from lmgcpy.experiment.campaign.campaign import Campaign
from lmgcpy.experiment.campaign.description import function_of
from lmgcpy.experiment.column.study import ColumnStudy
from lmgcpy.experiment.texsol.study import Study2D, Study3D
from lmgcpy.io.untrusted import regular_file

STUDIES: dict[str, Any] = {"texsol": Study2D, "texsol-3d": Study3D, "column": ColumnStudy}
"""Studies by the words for them."""
KEYS = ("study", "case_timeout", "fixed", "over", "cases")


def read_campaign(path: str | os.PathLike) -> Campaign:
    """The campaign of a TOML file; ValueError or TypeError with a sentence that names the file.

    A function is looked for beside the file as well.
    """
    file = Path(regular_file(path, "the file of a campaign"))
    try:
        about = tomllib.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:  # of TOML, or of what is no text
        raise ValueError(f"'{path}' is no TOML file: {error}.") from error
    for key in about:
        if key not in KEYS:
            raise ValueError(f"'{path}' has an unknown key '{key}'{closest(key, KEYS)}")
    word = about.pop("study", None)
    if not isinstance(word, str):
        raise ValueError(f"'{path}' must say the study, for example study = \"texsol-3d\", got {shown(word)}.")
    try:
        return Campaign(_work(word, file.resolve().parent), **about)
    except (TypeError, ValueError) as error:
        raise type(error)(f"'{path}': {error}") from error


def _work(word: str, beside: Path) -> Any:
    if word in STUDIES:
        return STUDIES[word]()
    if ":" not in word:
        raise ValueError(f"There is no study '{word}'{closest(word, [*STUDIES, 'module:function'])}")
    if str(beside) not in sys.path:
        sys.path.insert(0, str(beside))  # processes of this machine begin with the same path
    return function_of(word)
