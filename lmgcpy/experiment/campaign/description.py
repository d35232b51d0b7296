"""The description of a campaign: a study or a function, the parameters that are varied, and the cases that result."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import itertools
import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from lmgcpy.errors import closest, named_arguments, number, shown
from lmgcpy.experiment.campaign.words import in_words
from lmgcpy.experiment.study.engine import Study

Parameter = float | str | bool | None | tuple
PLAIN = (bool, int, float, str, type(None))
"""Types of a parameter, which a file can hold; a tuple holds some of them."""
LONGEST = 150
"""Most bytes of the name of a case, which also names its folder: file systems count bytes, and allow 255."""
MOST = 1_000_000
"""Most cases of a campaign."""


@dataclass(frozen=True)
class CampaignCase:
    """One of the computations of a campaign."""

    name: str
    """Its parameters in words, which name its folder."""
    parameters: dict[str, Parameter]
    """The parameters by which it differs from the others."""
    work: Any
    """The study to be carried out, or the function to be called."""
    arguments: dict[str, Parameter]
    """All arguments of the function; empty for a study."""


@named_arguments
@dataclass(frozen=True)
class CampaignDescription:
    """The computation of a campaign, with the fields of :class:`~lmgcpy.experiment.Campaign`."""

    work: Any
    over: Mapping[str, Iterable[Any]] = field(default_factory=dict)
    cases: Sequence[Mapping[str, Any]] = ()
    fixed: Mapping[str, Any] = field(default_factory=dict)
    case_timeout: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.work, Study) and not inspect.isfunction(self.work):
            raise TypeError(f"A campaign is of a study, or of a function of a module, got {shown(self.work)}.")
        if self.case_timeout is not None:
            object.__setattr__(self, "case_timeout", number(self.case_timeout, "case_timeout", above=0.0, unit="s"))
        if not isinstance(self.over, Mapping) or not isinstance(self.fixed, Mapping):
            raise TypeError("over and fixed of a campaign are mappings of parameters, as in over={'seed': range(5)}.")
        fixed = {name: _plain(value, name) for name, value in self.fixed.items()}
        over: dict[str, list[Parameter]] = {}
        for name, values in self.over.items():
            if isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
                raise TypeError(f"over['{name}'] of a campaign is a list of values, got {shown(values)}.")
            over[name] = [_plain(value, name) for value in values]
            if not over[name]:
                raise ValueError(f"over['{name}'] of a campaign has no value: there would be no case.")
        if isinstance(self.cases, (str, bytes, Mapping)) or not isinstance(self.cases, Iterable):
            raise TypeError(f"cases of a campaign is a list of mappings of parameters, got {shown(self.cases)}.")
        single = []
        for case in self.cases:
            if not isinstance(case, Mapping):
                raise TypeError(f"A case of a campaign is a mapping of parameters, got {shown(case)}.")
            single.append({name: _plain(value, name) for name, value in case.items()})
        for name, value in (("fixed", fixed), ("over", over), ("cases", single)):
            object.__setattr__(self, name, value)
        count = math.prod(len(values) for values in over.values())
        if count > MOST:
            raise ValueError(f"over of a campaign makes {count} cases, more than {MOST}: vary less at a time.")
        if not over and not single:
            raise ValueError("A campaign without over and cases has no case: give the parameters that are to be varied.")
        (name, count), *_ = Counter(case.name for case in self.all_cases()).most_common(1)
        if count > 1:
            raise ValueError(f"The campaign has the case '{name}' twice: take one of them out.")

    def all_cases(self) -> list[CampaignCase]:
        """The cases in their order: the combinations of ``over``, then ``cases``."""
        combined = [dict(zip(self.over, values, strict=True)) for values in itertools.product(*self.over.values())]
        return [self._case(parameters) for parameters in [*(combined if self.over else []), *self.cases]]

    def _case(self, parameters: Mapping[str, Any]) -> CampaignCase:
        own = dict(parameters)
        given = {**self.fixed, **own}
        name = case_name(own)
        if isinstance(self.work, Study):
            return CampaignCase(name, own, _study_with(self.work, given, name), {})
        try:
            inspect.signature(self.work).bind("site", **given)
        except TypeError as error:
            raise TypeError(f"Case '{name}': {self.work.__name__}(site, ...) cannot be called so: {error}.") from error
        return CampaignCase(name, own, self.work, given)

    def described(self) -> dict[str, Any]:
        """The description that a folder keeps: plain words, numbers and lists. The case_timeout may change on the way."""
        fields: dict[str, Any] = {}
        named: Any = self.work
        if isinstance(self.work, Study):
            named = type(self.work)
            # how many tests run at once changes no result
            fields = {name: _listed(v) for name, v in dataclasses.asdict(self.work).items() if name != "threads"}  # type: ignore[call-overload]
        return {
            "work": f"{named.__module__}:{named.__qualname__}",
            "study": fields,
            "fixed": {name: _listed(value) for name, value in self.fixed.items()},
            "cases": [{name: _listed(v) for name, v in case.parameters.items()} for case in self.all_cases()],
        }


def case_name(parameters: Mapping[str, Any]) -> str:
    """The parameters of a case in words that can name a folder: "bead_count=200,axes=z,seed=0"."""
    words = ",".join(f"{name}={in_words(value)}" for name, value in parameters.items()) or "case"
    name = re.sub(r"[^\w=,.+-]", "_", words)
    if len(name.encode()) > LONGEST:
        raise ValueError(f"The name of a case would have more than {LONGEST} bytes: '{name[:60]}...'. Vary less.")
    return name


def function_of(path: str) -> Callable[..., Any]:
    """The function that "module:function" names; ValueError with a sentence if there is none."""
    module, _, name = path.partition(":")
    try:
        found = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(f"The campaign's function '{path}' cannot be imported: {error}.") from error
    if not inspect.isfunction(found):
        raise ValueError(f"The campaign's '{path}' is no function: give 'module:function'.")
    return found


def _study_with(study: Study, given: Mapping[str, Any], case: str) -> Study:
    """The study with other values of some of its fields. A single value is taken as a tuple of one."""
    fields = {item.name: getattr(study, item.name) for item in dataclasses.fields(study)}  # type: ignore[arg-type]
    for name in given:
        if name not in fields or name == "threads":
            known = [name for name in fields if name != "threads"]
            raise ValueError(f"{type(study).__name__} has no parameter '{name}' to be varied{closest(name, known)}")
    values = {
        name: (value,) if isinstance(fields[name], tuple) and not isinstance(value, tuple) else value
        for name, value in given.items()
    }
    try:
        return dataclasses.replace(study, **values, threads=1)  # type: ignore[type-var]
    except (TypeError, ValueError) as error:
        raise type(error)(f"Case '{case}': {error}") from error


def _plain(value: Any, name: str) -> Parameter:
    """A parameter as a file can hold it; TypeError with a sentence if no file can."""
    value = value.item() if hasattr(value, "item") and getattr(value, "ndim", 0) == 0 else value
    if isinstance(value, (list, tuple)):
        return tuple(_plain(item, name) for item in value)
    if isinstance(value, str) and not is_text(value):
        raise ValueError(f"Parameter '{name}' of a campaign is {shown(value)}, which no file can hold.")
    if not isinstance(value, PLAIN):
        raise TypeError(f"Parameter '{name}' of a campaign is a number, a word or a tuple of these, got {shown(value)}.")
    return value


def is_text(word: str) -> bool:
    """Whether a file can hold it: not so of lone surrogates."""
    try:
        word.encode()
    except UnicodeEncodeError:
        return False
    return True


def _listed(value: Any) -> Any:
    return [_listed(item) for item in value] if isinstance(value, tuple) else value
