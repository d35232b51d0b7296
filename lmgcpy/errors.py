"""Checks of arguments. Each raises a built-in exception with a sentence: what is wrong, where, and what to do."""

from __future__ import annotations

import difflib
import errno
import functools
import inspect
import math
import os
import re
import stat
import sys
import warnings
from collections.abc import Callable, Iterable
from types import FrameType
from typing import Any, TypeVar

import numpy as np

AXES = "xyz"
"""Names of the axes, as sentences and arguments have them."""
LARGEST = 1e70
"""Largest number that is accepted. Larger ones are no quantities of mechanics in SI units, and their squares and products
would overflow. A number that must be above zero is at least the inverse."""
SHOWN = 80
"""Number of characters of a wrong value that a sentence shows."""
LISTED = 20
"""Number of known words that a sentence lists."""

Decorated = TypeVar("Decorated", bound=Callable)


def told(value: object, how: Callable[[object], str] = repr) -> str:
    """``repr(value)``, or what there is to say of a value whose ``__repr__`` fails; ``how``: str in place of repr."""
    try:
        return how(value)
    except (Exception, SystemExit, GeneratorExit):
        return f"<{type(value).__name__} that cannot be shown>"


def shown(value: object) -> str:
    """``repr(value)`` shortened for a sentence: one line, not too long, without an address in memory."""
    value = value.item() if isinstance(value, np.generic) else value
    text = re.sub(r" at 0x[0-9a-fA-F]+", "", " ".join(told(value).split()))
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 4]} ..."


def closest(word: object, known: Iterable[str]) -> str:
    """The end of a sentence about an unknown word: the closest match, if there is one, and the list of known words."""
    names = sorted(known)
    match = difflib.get_close_matches(str(word), names, n=1, cutoff=0.5)
    hint = f"; did you mean '{match[0]}'?" if match else "."
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return f"{hint} Known: {', '.join(names[:LISTED]) if names else 'none'}{more}."


def one_of(value: Any, name: str, known: Iterable[str]) -> str:
    """``value``, if it is one of the ``known`` words; raises TypeError or ValueError with a sentence that names it."""
    known = list(known)
    if not isinstance(value, str):
        raise TypeError(f"{name} must be one of {', '.join(map(repr, known))}, got {shown(value)}.")
    if value not in known:
        raise ValueError(f"{name} cannot be {shown(value)}{closest(value, known)}")
    return value


def flag(value: Any, name: str) -> bool:
    """``value``, if it is True or False; raises TypeError with a sentence that names it."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be True or False, got {shown(value)}.")
    return bool(value)


def number(
    value: Any,
    name: str,
    *,
    minimum: float = -math.inf,
    maximum: float = math.inf,
    above: float = -math.inf,
    unit: str = "",
) -> float:
    """``value`` as a finite float within bounds (``above`` is exclusive).

    Raises TypeError for a value that is no number, and ValueError for NaN, infinity or a number out of bounds. The
    sentence names it.
    """
    unit = f" {unit}" if unit and unit != "-" else ""
    no_number = f"{name} must be a number{unit and ' in' + unit}, got {shown(value)}."
    if isinstance(value, (bool, np.bool_, str, bytes, bytearray, list, tuple)) or value is None or np.ndim(value) > 0:
        raise TypeError(no_number)
    try:
        result = float(value)
    except OverflowError:
        result = math.inf
    except (TypeError, ValueError) as error:
        raise TypeError(no_number) from error
    if not math.isfinite(result):
        raise ValueError(f"{name} must be finite, got {shown(value)}.")
    if not result > above and above != -math.inf:
        raise ValueError(f"{name} must be above {above:g}{unit}, got {result:g}{unit}.")
    if result < minimum:
        raise ValueError(f"{name} must be at least {minimum:g}{unit}, got {result:g}{unit}.")
    if result > maximum:
        raise ValueError(f"{name} must be at most {maximum:g}{unit}, got {result:g}{unit}.")
    if abs(result) > LARGEST:
        raise ValueError(f"{name} must be at most {LARGEST:g}{unit} in size, got {result:g}{unit}.")
    if above == 0.0 and result < 1.0 / LARGEST:
        raise ValueError(f"{name} must be at least {1.0 / LARGEST:g}{unit}, got {result:g}{unit}.")
    return result


def whole(value: Any, name: str, *, minimum: int = 0, maximum: int = 2**62) -> int:
    """``value`` as an integer within bounds; raises TypeError or ValueError with a sentence that names it."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"{name} must be a whole number, got {shown(value)}.")
    if value < minimum:
        raise ValueError(f"{name} must be at least {minimum}, got {shown(value)}.")
    if value > maximum:
        raise ValueError(f"{name} must be at most {maximum}, got {shown(value)}.")
    return int(value)


def is_infinite(value: Any) -> bool:
    """Whether a value is the number infinity, with which some arguments leave something free."""
    return np.ndim(value) == 0 and bool(value == math.inf)


def numbers(value: Any, name: str, what: str = "an array of numbers") -> np.ndarray:
    """``value`` as a new contiguous array of finite floats of any shape.

    Raises TypeError if it holds anything but numbers, and ValueError for NaN or infinity. The sentence names it.
    """

    def no_numbers() -> TypeError:
        return TypeError(f"{name} must be {what}, got {shown(value)}.")

    try:
        given = np.asarray(value)
        if given.dtype.kind == "O":
            given = np.vectorize(lambda item: number(item, name), otypes=[float])(given)
    except TypeError as error:
        raise no_numbers() from error
    except ValueError as error:
        if not str(error).startswith(name):  # the error is numpy's: rows of different lengths
            raise no_numbers() from error
        raise
    if given.dtype.kind not in "iuf":
        raise no_numbers()
    result = np.array(given, dtype=np.float64, order="C")
    wrong = ~(np.abs(result) <= LARGEST)
    if wrong.any():
        first = result[wrong][0]
        if math.isfinite(first):
            raise ValueError(f"{name} must be at most {LARGEST:g} in size, got {first:g}.")
        many = f": {np.count_nonzero(~np.isfinite(result))} of {result.size} numbers are not" if result.size > 3 else ""
        raise ValueError(f"{name} must be finite, got {shown(value)}{many}.")
    return result


def vector(value: Any, name: str, size: int) -> np.ndarray:
    """``value`` as a finite float array of shape (size,); raises TypeError or ValueError with a sentence that names it."""
    result = numbers(value, name, f"{size} numbers")
    if result.shape != (size,):
        shape = f"{result.size} numbers" if result.ndim == 1 else f"an array of shape {result.shape}"
        raise ValueError(f"{name} must be {size} numbers in dimension {size}, got {shape}: {shown(value)}.")
    return result


def read_only(array: np.ndarray) -> np.ndarray:
    """The array itself, from now on to read: if a user wrote into it, nothing else would change."""
    array.flags.writeable = False
    return array


def file_path(value: Any, name: str) -> str:
    """``value`` as the path of a file or folder; raises TypeError or ValueError with a sentence that names it."""
    if not isinstance(value, (str, os.PathLike)) or not isinstance(os.fspath(value), str):
        raise TypeError(f"{name} must be the path of a file, got {shown(value)}.")
    if not os.fspath(value) or "\0" in os.fspath(value):
        raise ValueError(f"{name} must be the path of a file, got {shown(value)}.")
    return os.fspath(value)


def regular_file(path: str | os.PathLike, what: str) -> str:
    """The path of a regular file that can be read.

    Raises TypeError, FileNotFoundError, IsADirectoryError, PermissionError, and ValueError for a pipe or a device, because
    a read from it might never end.
    """
    path = file_path(path, "path")
    if not os.path.exists(path):
        raise FileNotFoundError(f"There is no file '{path}'.")
    mode = os.stat(path).st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(f"'{path}' is a folder, not {what}.")
    if not stat.S_ISREG(mode):
        raise ValueError(f"'{path}' is a pipe or a device, not {what}: write what comes from there into a file first.")
    if not os.access(path, os.R_OK):
        raise PermissionError(f"The file '{path}' may not be read: change its permissions.")
    return path


def system_error(what: str, cause: BaseException, remedy: str) -> OSError:
    """An OSError with a sentence that quotes the words of its cause, and with the error number of its cause."""
    words = str(getattr(cause, "strerror", None) or cause).split(" (")[0]  # HDF5 adds details in brackets
    error = OSError(f"{what}: {words}. {remedy}")
    error.errno = getattr(cause, "errno", None) or errno.EIO
    return error


PACKAGE = os.path.dirname(os.path.abspath(__file__)) + os.sep


def warn(sentence: str, category: type[Warning] = RuntimeWarning) -> None:
    """Warn at the line of the user's code: the innermost one that is not lmgcpy's own."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and os.path.abspath(_file_of(frame)).startswith(PACKAGE):
        frame, level = frame.f_back, level + 1
    warnings.warn(sentence, category, stacklevel=level)


def _file_of(frame: FrameType) -> str:
    """File of the code of a frame; of code that a dataclass made, that of its module."""
    return frame.f_globals.get("__file__") or frame.f_code.co_filename


def named_arguments(decorated: Decorated) -> Decorated:
    """Decorator of a public function or class: a call with a wrong set of arguments raises TypeError with a sentence.

    The sentence names an unknown argument, with the closest match, a missing one, or one that must have a name.
    """
    function: Callable = decorated.__init__ if isinstance(decorated, type) else decorated  # type: ignore[misc]

    @functools.wraps(function)
    def call(*given: Any, **named: Any) -> Any:
        try:
            return function(*given, **named)
        except TypeError as error:
            if error.__traceback__ is None or error.__traceback__.tb_next is not None:
                raise  # the function raised it, not the call
            raise TypeError(_wrong_call(function, given, named)) from None

    if isinstance(decorated, type):
        decorated.__init__ = call  # type: ignore[misc]
        return decorated
    return call  # type: ignore[return-value]


def _arguments(kind: type) -> list[str]:
    """Names of the arguments of a class: its own, and those that it hands on to the class above, but for what it
    ``GIVES`` that class itself."""
    names: list[str] = []
    given: set[str] = set()
    for above in kind.__mro__:
        if "__init__" in vars(above):
            parameters = list(inspect.signature(above.__init__).parameters.values())[1:]  # type: ignore[misc]
            names += [p.name for p in parameters if p.kind is not p.VAR_KEYWORD and p.name not in {*names, *given}]
            if all(p.kind is not p.VAR_KEYWORD for p in parameters):
                break
        given |= set(vars(above).get("GIVES", ()))
    return names


def _wrong_call(function: Callable, given: tuple, named: dict[str, Any]) -> str:
    parameters = list(inspect.signature(function).parameters.values())
    name = function.__name__
    if parameters and parameters[0].name == "self":
        name = type(given[0]).__name__ if name == "__init__" else f"{type(given[0]).__name__}.{name}"
        parameters, instance, given = parameters[1:], given[0], given[1:]
    own = [p.name for p in parameters if p.kind is not p.VAR_KEYWORD]
    known = _arguments(type(instance)) if function.__name__ == "__init__" else own
    for word in named:
        if word not in own and word not in known:
            return f"{name} has no argument '{word}'{closest(word, known)}"
    by_position = [p.name for p in parameters if p.kind not in (p.KEYWORD_ONLY, p.VAR_KEYWORD)]
    if len(given) > len(by_position):
        allowed = f"only {', '.join(by_position)} without a name" if by_position else "its arguments by name only"
        return f"{name} takes {allowed}, got {shown(given[len(by_position)])} without one."
    taken = by_position[: len(given)]
    for word in taken:
        if word in named:
            return f"{name} got {word} twice: once without a name and once as {word}={shown(named[word])}."
    needed = [p.name for p in parameters if p.default is p.empty and p.kind is not p.VAR_KEYWORD]
    missing = [word for word in needed if word not in taken and word not in named]
    return f"{name} needs {' and '.join(missing)}: {name}({', '.join(f'{word}=...' for word in needed)})."
