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


def imported(source: Path) -> set[str]:
    """The rooms that a file imports, wherever in the file; an empty text for the package itself."""
    modules: set[str] = set()
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module is not None:
            package = node.module == "a2s_drake"
            modules |= {f"a2s_drake.{alias.name}" for alias in node.names} if package else {node.module}
    ours = {module for module in modules if module.split(".")[0] in ("a2s_drake", "diagrams", "scripts")}
    return {room_of(module) for module in ours}


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.relative_to(ROOT).as_posix())
def test_imports_run_downward_only(source: Path) -> None:
    own = room_of(".".join(source.relative_to(ROOT).with_suffix("").parts))
    if own in ("__init__", "scripts"):
        return  # the public names, and the doors: both may import from every room
    others = imported(source) - {own}
    assert others <= set(FLOOR_OF), "the library imports names from the room that they live in"
    assert {room for room in others if FLOOR_OF[room] >= FLOOR_OF[own]} == set()


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
