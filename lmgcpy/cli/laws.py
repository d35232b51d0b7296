"""Commands on laws: ``laws`` lists them, ``plugin new`` begins a plug-in."""

from __future__ import annotations

import inspect
import sys
from pathlib import Path

import click

import lmgcpy
from lmgcpy import laws as registered
from lmgcpy.contact.contactor_pairs import known_pairs
from lmgcpy.errors import closest, told
from lmgcpy.laws import Law, Parameter
from lmgcpy.laws.law import REQUIRED
from lmgcpy.laws.pair import TAKE_PAIR, takes_pair


@click.command()
@click.argument("name", required=False)
@click.option("--check", is_flag=True, help="Run the conformance kit on the law NAME and print its report.")
@click.option("--set", "given", multiple=True, metavar="PARAMETER=VALUE", help="Parameter of the law for --check.")
def laws(name: str | None, check: bool, given: tuple[str, ...]) -> None:
    """List all laws with their parameters, or describe the law NAME.

    The list also names the plug-ins that failed to load, with the reason.
    """
    if name is None:
        if check or given:
            raise click.UsageError("--check and --set are about one law: name it, as in lmgcpy laws coulomb --check.")
        for law_name in registered.names():
            click.echo(line(registered.get(law_name)))
        for plugin, error in registered.failures().items():
            click.echo(f"Plug-in {plugin} failed to load: {type(error).__name__}: {told(error, str)}")
        return
    law = registered.get(name)
    for text in about(law):
        click.echo(text)
    if check:
        from lmgcpy.testing import report

        result = report(law(**values(law, given)))
        click.echo()
        click.echo(str(result))
        if not result.conforms:
            sys.exit(1)


def origin(law: type[Law]) -> str:
    """Distribution and version of a law."""
    distribution = registered.registrations()[law.NAME].distribution
    return f"lmgcpy {lmgcpy.__version__}" if distribution == "lmgcpy" else distribution


def line(law: type[Law]) -> str:
    """A law in one line: name, parameters with units, contactors, distribution."""
    given = ", ".join(f"{key} [{parameter.unit}]" for key, parameter in law.parameters().items())
    return f"{law.NAME:<14} {law.APPLIES_TO:<8} ({given})  {pairs(law)}; {origin(law)}"


def pairs(law: type[Law]) -> str:
    """Kinds of contactors that a law serves."""
    if law.APPLIES_TO == "link":
        return "two bodies"
    return ", ".join("-".join(pair) for pair in sorted(law.PAIRS or known_pairs()))


def about(law: type[Law]) -> list[str]:
    """The description of a law, line by line."""
    lines = [f"{law.NAME}: {law.APPLIES_TO} law, {law.__module__}.{law.__qualname__}, from {origin(law)}", ""]
    lines += inspect.cleandoc(law.__doc__ or "No description.").splitlines()
    lines += ["", "parameters"]
    lines += [f"  {key} [{p.unit}]{bounds(p)}  {p.text}".rstrip() for key, p in law.parameters().items()] or ["  none"]
    if law.states():
        lines.append("state of each interaction")
        lines += [f"  {key} [{state.unit}]  {state.text}".rstrip() for key, state in law.states().items()]
    functions = "slope", "energy", "conic", "resisted", "initial", "commit"
    optional = [name for name in functions if getattr(law, name) is not None]
    lines.append(f"between     {pairs(law)}")
    lines.append(f"functions   {', '.join(['prepare', 'react', *optional])}")
    lines.append(f"promises    {', '.join(sorted(law.TRAITS)) or 'nothing'}")
    asking = [name for name in TAKE_PAIR if takes_pair(getattr(law, name))]
    lines += [f"take pair   {', '.join(asking)}"] if asking else []
    return lines


def bounds(parameter: Parameter) -> str:
    """The bounds and the default of a parameter, in words."""
    limits = [
        (words, parameter.bounds[key])
        for key, words in (("above", "above"), ("minimum", "at least"), ("maximum", "at most"))
    ]
    clauses = [f"{words} {value:g}" for words, value in limits if abs(value) < float("inf")]
    if parameter.default is None:
        clauses.append("may be left out")
    elif parameter.default is not REQUIRED:
        clauses.append(f"{parameter.default:g} if left out")
    return f", {', '.join(clauses)}:" if clauses else ":"


def values(law: type[Law], given: tuple[str, ...]) -> dict[str, float]:
    """Parameters from PARAMETER=VALUE texts."""
    found = {}
    for text in given:
        key, _, value = text.partition("=")
        if key not in law.parameters():
            raise ValueError(f"Law '{law.NAME}' has no parameter '{key}'{closest(key, law.parameters())}")
        try:
            found[key] = float(value)
        except ValueError:
            raise ValueError(f"--set takes PARAMETER=VALUE with a number, got '{text}'.") from None
    return found


@click.group()
def plugin() -> None:
    """Make plug-ins, which are distributions with laws of their own."""


@plugin.command()
@click.argument("name")
@click.option("--kind", default="contact", help="What the law applies to: contact or link.")
@click.option("--into", "folder", type=click.Path(path_type=Path), default=Path("."), help="Folder for the plug-in.")
def new(name: str, kind: str, folder: Path) -> None:
    """Begin a plug-in with the law NAME, a distribution that can be installed and passes its own tests."""
    from lmgcpy.plugin_template import write_plugin

    written = write_plugin(name, folder, kind=kind)
    for path in written:
        click.echo(path)
    target = written[0].parent
    click.echo(
        f'Next: cd {target}, then pip install -e ".[test]" and pytest. The law is in {written[2].relative_to(target)}.'
    )


COMMANDS = (laws, plugin)
