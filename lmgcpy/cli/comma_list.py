"""The type of options that take values separated by commas."""

from __future__ import annotations

from typing import Any

import click

NOUNS: dict[type, str] = {str: "words", int: "whole numbers", float: "numbers"}


class CommaList(click.ParamType):
    """Values of one type, separated by commas, as a tuple.

    ``count``: number of values, any number if None; ``or_word``: a value without a comma is taken as a word.
    """

    def __init__(self, kind: type, example: str, *, count: int | None = None, or_word: bool = False):
        self.name = NOUNS[kind]
        self.kind, self.example, self.count, self.or_word = kind, example, count, or_word

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The tuple, or the word."""
        if not isinstance(value, str) or (self.or_word and "," not in value):
            return value
        parts = [part.strip() for part in value.split(",")]
        if self.count is None:
            parts = [part for part in parts if part]
        try:
            values = tuple(self.kind(part) for part in parts)
        except ValueError:
            values = None
        if values is None or self.count not in (None, len(values)):
            wanted = f"{self.count or 'a list of'} {self.name} separated by commas, such as {self.example}"
            self.fail(f"'{value}' is not {wanted}", param, ctx)
        return values
