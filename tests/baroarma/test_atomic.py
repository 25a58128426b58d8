"""Files that are complete or not there, whoever else writes them."""

import os
import stat
import threading
from pathlib import Path

import pytest

from baroarma.atomic import replacing


def test_a_failure_leaves_the_older_file_and_no_other(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")
    with pytest.raises(UnicodeEncodeError), replacing(target) as temporary:
        temporary.write_text("half \ud800")
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_of_many_writers_at_once_each_writes_a_whole_file(tmp_path):
    target, seen, stop = tmp_path / "a.txt", set(), threading.Event()
    texts = [str(k) * 100_000 for k in range(6)]
    target.write_text(texts[0])

    def write(text):
        for _ in range(30):
            with replacing(target) as temporary:
                temporary.write_text(text)

    def watch():
        while not stop.is_set():
            seen.add(target.read_text())

    threads = [threading.Thread(target=write, args=(text,)) for text in texts]
    watcher = threading.Thread(target=watch)
    for thread in (watcher, *threads):
        thread.start()
    for thread in threads:
        thread.join()
    stop.set()
    watcher.join()
    assert seen <= set(texts)
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.skipif(os.name == "nt", reason="links and modes are POSIX's")
def test_a_link_stays_a_link_and_a_file_keeps_its_mode(tmp_path):
    (tmp_path / "data").mkdir()
    real, link = tmp_path / "data" / "a.txt", tmp_path / "latest"
    real.write_text("old")
    real.chmod(0o640)
    link.symlink_to(real)
    with replacing(link) as temporary:
        temporary.write_text("new")
    assert link.is_symlink()
    assert real.read_text() == "new"
    assert stat.S_IMODE(real.stat().st_mode) == 0o640
    assert [p.name for p in real.parent.iterdir()] == ["a.txt"]


def test_the_longest_name_can_be_written(tmp_path):
    target = tmp_path / ("x" * 255)
    with replacing(target) as temporary:
        temporary.write_text("new")
    assert target.read_text() == "new"


def test_another_error_of_the_system_stays_what_it_is(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"missing\.txt"), replacing(tmp_path / "a.txt"):
        Path(tmp_path / "missing.txt").read_text()
    with pytest.raises(OSError, match="no number"), replacing(tmp_path / "a.txt"):
        raise OSError("no number")
    with pytest.raises(IsADirectoryError), replacing(tmp_path) as temporary:
        temporary.write_text("x")
