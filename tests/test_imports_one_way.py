"""Imports run one way: no floor of the package imports one above it, and no file imports one that imports it back."""

import ast
import importlib
import re
from functools import cache
from pathlib import Path

import lmgcpy

ROOT = Path(lmgcpy.__file__).parent
FLOORS = """
    version errors
    writing
    compiled
    laws
    contact
    solve
    dynamics
    scene
    io
    measure sample
    view
    simulation continuum
    lmgcpy
    experiment
    plugin_template bench testing examples
    warmup
    cli
"""
FLOOR = {room: number for number, line in enumerate(FLOORS.split("\n")) for room in line.split()}


@cache
def imports() -> dict[str, set[str]]:
    """The files of the package by what they import of it, inside functions and for types only as well."""
    dotted = {path: ".".join(path.relative_to(ROOT.parent).with_suffix("").parts) for path in ROOT.rglob("*.py")}
    names = {name.removesuffix(".__init__"): path for path, name in dotted.items()}
    taken: dict[str, set[str]] = {name: set() for name in names}
    for name, path in names.items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{path}: a relative import"
                full = [f"{node.module}.{alias.name}" for alias in node.names]
                taken[name] |= {one if one in names else str(node.module) for one in full} & names.keys()
            elif isinstance(node, ast.Import):
                taken[name] |= {alias.name for alias in node.names} & names.keys()
    return taken


def room(name: str) -> str:
    return name.split(".")[1] if "." in name else name


def test_no_floor_imports_one_above_it():
    arrows = {(name, other) for name, others in imports().items() for other in others if room(name) != room(other)}
    assert {room(name) for name in imports()} == FLOOR.keys()
    assert [f"{name} -> {other}" for name, other in sorted(arrows) if FLOOR[room(other)] >= FLOOR[room(name)]] == []


def test_rooms_of_solve_are_read_from_the_top_down():
    """Solvers, Newton steps, sweeps, kernels, problems: each imports only what stands below it."""
    order = ["problems", "kernels", "sweeps", "newton"]
    inside = {name: others for name, others in imports().items() if name.startswith("lmgcpy.solve.")}

    def level(name: str) -> int:
        found = name.split(".")[2]
        return order.index(found) if found in order else len(order)

    arrows = [(name, other) for name, others in inside.items() for other in others & inside.keys()]
    assert len(arrows) > len(inside)
    assert [f"{name} -> {other}" for name, other in arrows if level(other) > level(name)] == []


def test_no_circles():
    """Files that import none of those left, and files that none of those left imports, are taken away: circles stay."""
    left = {name: others - {name} for name, others in imports().items()}
    while True:
        imported = set().union(*left.values()) if left else set()
        free = [name for name, others in left.items() if not others & left.keys() or name not in imported]
        if not free:
            break
        for name in free:
            del left[name]
    assert left == {}


def test_programs_import_what_is_there():
    """Of the package, and by its present names: benchmarks, tutorials and plug-ins are not type-checked."""
    missing = []
    for folder in ("benchmarks", "tutorials", "plugins"):
        for path in (ROOT.parent / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] == "lmgcpy":
                    module = importlib.import_module(str(node.module))
                    missing += [f"{path.name}: {node.module}.{a.name}" for a in node.names if not hasattr(module, a.name)]
    assert missing == []


def test_a_class_name_occurs_once():
    """A reader who meets a name finds one class behind it."""
    names = [
        name for path in ROOT.rglob("*.py") for name in re.findall(r"^class (\w+)", path.read_text(encoding="utf-8"), re.M)
    ]
    assert sorted({name for name in names if names.count(name) > 1}) == []


def test_a_file_gives_a_name_once():
    """A second constant of one name would take the place of the first, in the functions above it as well."""
    twice = []
    for path in set(ROOT.rglob("*.py")) - set((ROOT / "examples").glob("[!_]*.py")):  # scripts, read from the top down
        given = [
            target.id
            for node in ast.parse(path.read_text(encoding="utf-8")).body
            if isinstance(node, ast.Assign | ast.AnnAssign)
            for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
            if isinstance(target, ast.Name)
        ]
        twice += [f"{path.relative_to(ROOT)}: {name}" for name in sorted({n for n in given if given.count(n) > 1})]
    assert twice == []
