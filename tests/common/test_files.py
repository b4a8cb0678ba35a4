"""Files are written whole or not at all: through links, beside other processes, with the right permissions."""

import os
import stat
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from a2s_drake.common.files import check_folder, check_writable, held, written_whole
from tests.support.damage import full_disk

LONG = "n" * 300


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A file that is there already."""
    (tmp_path / "file").write_text("old")
    return tmp_path / "file"


def write(path: Path, text: str = "new") -> None:
    with written_whole(path) as part:
        part.write_text(text)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_takes_its_place_at_the_end(file: Path) -> None:
    with written_whole(file) as part:
        part.write_text("new")
        assert part.parent == file.parent
        assert file.read_text() == "old"
    assert file.read_text() == "new"
    assert names(file.parent) == ["file"]


@pytest.mark.parametrize("end", [KeyboardInterrupt, OSError, ValueError])
def test_what_is_left_half_written_goes(end: type[BaseException], file: Path) -> None:
    with pytest.raises(end), written_whole(file) as part:
        part.write_text("half")
        raise end
    assert file.read_text() == "old"
    assert names(file.parent) == ["file"]


def test_two_that_write_the_same_file_do_not_meet(file: Path) -> None:
    with written_whole(file) as first, written_whole(file) as second:
        first.write_text("first")
        second.write_text("second")
    assert file.read_text() == "first"
    assert names(file.parent) == ["file"]


WRITER = """
import sys
from pathlib import Path
from a2s_drake.common.files import written_whole
for _ in range(300):
    with written_whole(Path(sys.argv[1])) as part:
        part.write_text(sys.argv[2] * 10000)
"""


def test_two_processes_write_the_same_file(file: Path) -> None:
    command = [sys.executable, "-c", WRITER, str(file)]
    writers = [subprocess.Popen([*command, letter], stderr=subprocess.PIPE, text=True) for letter in "ab"]
    assert [(writer.communicate(timeout=120)[1], writer.returncode) for writer in writers] == [("", 0), ("", 0)]
    assert file.read_text() in ("a" * 10000, "b" * 10000)
    assert names(file.parent) == ["file"]


@pytest.mark.parametrize("name", ["n" * 255, "ü" * 127, "with\nnewline", ".part-0"])
def test_any_name_that_the_folder_allows_can_be_written(name: str, tmp_path: Path) -> None:
    write(tmp_path / name)
    check_writable(tmp_path / name)
    assert names(tmp_path) == [name]


@pytest.fixture
def umask() -> Iterator[None]:
    before = os.umask(0o027)
    yield
    os.umask(before)


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.usefixtures("umask")
def test_a_new_file_has_the_permissions_that_the_umask_leaves(tmp_path: Path) -> None:
    write(tmp_path / "file")
    assert mode(tmp_path / "file") == 0o640


@pytest.mark.usefixtures("umask")
@pytest.mark.parametrize("permissions", [0o600, 0o664, 0o444, 0o400])
def test_permissions_stay(permissions: int, file: Path) -> None:
    file.chmod(permissions)
    with written_whole(file) as part:
        assert mode(part) | 0o200 == permissions | 0o200  # others see no more while it is written
        part.write_text("new")
    assert mode(file) == permissions
    assert file.read_text() == "new"


@pytest.mark.parametrize("there", [True, False])
def test_a_link_stays_and_what_it_leads_to_is_written(there: bool, tmp_path: Path) -> None:
    (tmp_path / "links").mkdir()
    (tmp_path / "files").mkdir()
    target, link, first = tmp_path / "files" / "target", tmp_path / "links" / "link", tmp_path / "links" / "first"
    if there:
        target.write_text("old")
    link.symlink_to("../files/target")
    first.symlink_to(link)
    check_writable(first)
    assert target.exists() == there
    write(first)
    assert first.is_symlink()
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert not target.is_symlink()
    assert (names(tmp_path / "links"), names(tmp_path / "files")) == (["first", "link"], ["target"])


def refused(path: Path) -> None:
    """Both the check and the writing name the path on one line."""
    for attempt in (check_writable, write):
        with pytest.raises(OSError, match=r"^.+$") as error:
            attempt(path)
        assert error.value.filename == str(path)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize("kind", ["folder", "pipe", "loop", "device", "link to a device", "link to nowhere"])
def test_what_is_no_regular_file_is_refused_and_stays(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "special"
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        if os.geteuid():
            pytest.skip("only root may make a device node")
        os.mknod(path, stat.S_IFCHR | 0o600, os.makedev(1, 3))
    else:
        path.symlink_to({"loop": path, "link to a device": "/dev/null", "link to nowhere": "no/where"}[kind])
    before = path.lstat()
    refused(path)
    assert (path.lstat().st_ino, path.lstat().st_mode) == (before.st_ino, before.st_mode)
    assert names(tmp_path) == ["special"]


@pytest.mark.parametrize("name", [LONG, "with\0nul", "missing/file"])
def test_a_name_that_cannot_be_is_refused(name: str, tmp_path: Path) -> None:
    refused(tmp_path / name)
    assert names(tmp_path) == []


def test_below_a_file_there_is_no_file(file: Path) -> None:
    refused(file / "below")


@pytest.mark.parametrize("folder", [".", "new", "new/newer"])
def test_a_folder_that_can_be_made_is_not_made_by_the_check(folder: str, tmp_path: Path) -> None:
    check_folder(tmp_path / folder)
    assert names(tmp_path) == []


@pytest.mark.parametrize("folder", ["file", "file/below", LONG, f"new/{LONG}", "with\0nul", "dangling"])
def test_a_folder_that_cannot_be_made_is_refused(folder: str, file: Path) -> None:
    (file.parent / "dangling").symlink_to("nowhere")
    with pytest.raises(OSError, match=r"^[^\n]+$"):
        check_folder(file.parent / folder)
    assert names(file.parent) == ["dangling", "file"]


def test_a_folder_that_root_itself_cannot_write_to_is_refused() -> None:
    if not Path("/proc/self").exists():
        pytest.skip("needs a /proc")
    with pytest.raises(OSError, match=r"^[^\n]+$"):
        check_folder(Path("/proc"))


def test_a_full_disk_names_the_file_and_leaves_it_as_it_was(file: Path) -> None:
    with full_disk(1000), pytest.raises(OSError, match=rf"^\[Errno 27\] File too large: '{file}'$"):
        write(file, 2000 * "a")
    assert file.read_text() == "old"
    assert names(file.parent) == ["file"]


def test_an_error_about_another_file_keeps_its_name(file: Path) -> None:
    with pytest.raises(FileNotFoundError, match="elsewhere"), written_whole(file):
        Path("elsewhere").read_text()


HOLDER = """
import sys, time
from pathlib import Path
from a2s_drake.common.files import held
with held(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(1.0)
"""


def test_a_folder_is_held_by_one_process_at_a_time(tmp_path: Path) -> None:
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        start = time.monotonic()
        with held(tmp_path):
            assert time.monotonic() - start > 0.5
            assert names(tmp_path) == []


def test_a_folder_that_cannot_be_held_is_used_all_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr("fcntl.flock", refuse)
    with held(tmp_path):
        pass
    with held(tmp_path / "missing"):
        pass
