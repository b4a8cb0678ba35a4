import ast
from pathlib import Path

import pytest

import a2s_drake

ROOT = Path(__file__).parents[2]
# Rooms that stand on one line do not import each other.
FLOORS = [
    {"common"},
    {"scenario", "solvers"},
    {"world"},
    {"vehicle", "link"},
    {"navigation", "control", "guidance"},
    {"flight"},
    {"diagrams"},
    {"study"},
    {"views"},
    {"benchmark"},
    {"scripts"},
]
FLOOR_OF = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
SOURCES = [source for top in ("a2s_drake", "diagrams", "scripts") for source in sorted((ROOT / top).rglob("*.py"))]


def room_of(module: str) -> str:
    first, *rest = module.split(".")
    return (rest[0] if rest else "") if first == "a2s_drake" else first


def package_of(source: Path) -> list[str]:
    """The package that relative imports of a file start from. The wheel carries `diagrams` inside `a2s_drake`."""
    package = list(source.relative_to(ROOT).parent.parts)
    return ["a2s_drake", *package] if package[:1] == ["diagrams"] else package


def imported(text: str, package: list[str]) -> set[str]:
    """The rooms that a file of a package imports, wherever in the file; an empty text for `a2s_drake` itself."""
    modules: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            start = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*start, *([node.module] if node.module else [])])
            modules |= {f"{module}.{alias.name}" for alias in node.names} if module == "a2s_drake" else {module}
        elif isinstance(node, ast.Call) and called(node) == "require":  # of `common/packages.py`, for extras
            modules |= {argument.value for argument in node.args[:1] if isinstance(argument, ast.Constant)}
    ours = {module for module in modules if module.split(".")[0] in ("a2s_drake", "diagrams", "scripts")}
    return {room_of(module) for module in ours}


def called(node: ast.Call) -> str:
    """The last name of what a call calls."""
    return getattr(node.func, "attr", getattr(node.func, "id", ""))


def imports_by_text(text: str) -> bool:
    """Whether a file imports modules by names that only running it tells."""
    named = {"import_module", "__import__"}
    nodes = list(ast.walk(ast.parse(text)))
    taken = {alias.name for node in nodes if isinstance(node, ast.ImportFrom) for alias in node.names}
    return bool(named & (taken | {called(node) for node in nodes if isinstance(node, ast.Call)}))


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.relative_to(ROOT).as_posix())
def test_imports_run_downward_only(source: Path) -> None:
    own = room_of(".".join(source.relative_to(ROOT).with_suffix("").parts))
    if own in ("__init__", "scripts"):
        return  # the public names, and the doors: both may import from every room
    others = imported(source.read_text(encoding="utf-8"), package_of(source)) - {own}
    assert others <= set(FLOOR_OF), "the library imports names from the room that they live in"
    assert {room for room in others if FLOOR_OF[room] >= FLOOR_OF[own]} == set()


@pytest.mark.parametrize(
    ("text", "folder", "rooms"),
    [
        ("import a2s_drake.study.pool", "a2s_drake/link", {"study"}),
        ("def f():\n    from a2s_drake.study import pool", "a2s_drake/link", {"study"}),
        ("from a2s_drake import study", "a2s_drake/link", {"study"}),
        ("from ..study import pool", "a2s_drake/link", {"study"}),
        ("from .. import study, views", "a2s_drake/link", {"study", "views"}),
        ("from ...study.pool import Pool", "a2s_drake/guidance/plan", {"study"}),
        ("from .spline import AttitudeSpline", "a2s_drake/guidance/plan", {"guidance"}),
        ("from . import spline", "a2s_drake/guidance", {"guidance"}),
        ("from .blocks import Blocks", "diagrams", {"diagrams"}),
        ("from ..study import pool", "diagrams", {"study"}),
        ("from scripts import common", "a2s_drake/views", {"scripts"}),
        ("require('a2s_drake.study', 'words')", "a2s_drake/link", {"study"}),
        ("import numpy\nfrom pydrake.math import RollPitchYaw", "a2s_drake/link", set()),
    ],
)
def test_an_import_is_seen_in_every_form(text: str, folder: str, rooms: set[str]) -> None:
    assert imported(text, package_of(ROOT / folder / "file.py")) == rooms


def test_no_room_imports_by_text() -> None:
    # The package fetches its public names when they are first used, and `require` fetches extras.
    allowed = {"a2s_drake/__init__.py", "a2s_drake/common/packages.py"}
    found = {source for source in SOURCES if imports_by_text(source.read_text(encoding="utf-8"))}
    assert {source.relative_to(ROOT).as_posix() for source in found} == allowed
    assert imports_by_text("from importlib import import_module as f")
    assert imports_by_text("__import__('a2s_drake.study')")


def test_every_room_stands_on_a_floor() -> None:
    entries = (ROOT / "a2s_drake").iterdir()
    rooms = {path.stem for path in entries if path.suffix == ".py" or (path / "__init__.py").exists()} - {"__init__"}
    assert rooms | {"scripts"} == set(FLOOR_OF)
    assert len(rooms) <= 17


def test_every_public_name_is_there() -> None:
    typed = [
        alias.name
        for node in ast.walk(ast.parse(Path(a2s_drake.__file__).read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("a2s_drake.")
        for alias in node.names
    ]
    assert sorted(typed) == sorted(a2s_drake.__all__)
    assert all(getattr(a2s_drake, name).__name__.rstrip("_") for name in a2s_drake.__all__ if not name.endswith("_"))


def test_an_unknown_name_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = a2s_drake.nothing  # type: ignore[attr-defined]


def test_files_are_short() -> None:
    assert [source.name for source in SOURCES if len(source.read_text(encoding="utf-8").splitlines()) > 300] == []
