"""Rows in, rows out, at once; and a plot for who watches, which never holds them up."""

import io
import os
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from rich.console import Console

from baroarma.cli import main
from baroarma.cli.common import Refusal
from baroarma.cli.live import MOST_ROWS, LivePlot, track_live
from baroarma.formats import write_csv
from baroarma.simulation import BMP085, simulate
from baroarma.tracker import Tracker

HEAD = "time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s"
COMMAND = [sys.executable, "-m", "baroarma", "track"]
ALIGNING = 50
"""Rows of the first second, which have no answer."""
LEFT, SHOWN = "\x1b[?1049l", "\x1b[?25h"
"""What gives a terminal its own screen back, and its cursor [xterm control sequences]."""


@pytest.fixture(scope="module")
def lines(tmp_path_factory):
    path = tmp_path_factory.mktemp("live") / "squat.csv"
    write_csv(simulate("squat", duration=8, seed=1), path)
    return path.read_text().splitlines(keepends=True)


@pytest.fixture
def tracker():
    return Tracker(noise=BMP085.noise)


def test_each_answer_is_out_before_the_next_row_is_read(lines, tracker, monkeypatch):
    out = io.StringIO()
    monkeypatch.setattr("sys.stdout", out)

    def rows():
        for k, line in enumerate(lines[:100]):
            answered = out.getvalue().count("\n")
            assert answered == 1 + max(0, k - 1 - ALIGNING)
            yield line

    track_live(tracker, rows(), None, None)
    assert out.getvalue().splitlines()[0] == HEAD


def test_the_answers_may_go_to_a_file(lines, tracker, tmp_path, capsys):
    track_live(tracker, lines, str(tmp_path / "t.csv"), None)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.match(r"350 rows answered; at 7.98 s height -?\+?[\d.]+ m .* -> .*t.csv\n", captured.err)
    track_live(Tracker(noise=BMP085.noise), lines, None, None)
    assert (tmp_path / "t.csv").read_text() == capsys.readouterr().out


def answers_to(lines, monkeypatch, capsys, *arguments):
    """Return exit code, answers and what was said of a stream of bytes."""
    data = io.BytesIO(b"".join(line if isinstance(line, bytes) else line.encode() for line in lines))
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(data, encoding="utf-8"))
    code = main(["track", "-", *arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err.splitlines()


GARBLED = {
    "a byte that is no text": lambda row: b"\xff" + row[1:],
    "half a row": lambda row: row[: len(row) // 2] + b"\n",
    "two rows in one": lambda row: row.rstrip() + row,
    "a cell that is no number": lambda row: row.replace(b".", b"/", 1),
    "another header, after a restart": lambda row: b"time_s,pressure_pa\n",
    "a comment": lambda row: b"# low battery\n",
}


@pytest.mark.parametrize("garble", GARBLED.values(), ids=GARBLED)
@pytest.mark.parametrize("at", [1, 20, 82, 400])
def test_a_garbled_row_is_skipped_told_and_leaves_the_others_answers(lines, monkeypatch, capsys, garble, at):
    garbled = [*lines[:at], garble(lines[at].encode()), *lines[at + 1 :]]
    code, out, said = answers_to(garbled, monkeypatch, capsys)
    assert (code, out) == (1, answers_to([*lines[:at], *lines[at + 1 :]], monkeypatch, capsys)[1])
    (told,) = [line for line in said if "skipped-row" in line]
    assert told.startswith(f"warning (skipped-row): standard input, line {at + 1}: ")
    assert said[-1].startswith("baroarma: 1 row skipped that could not be read; look for ")
    assert re.match(f"{len(out.splitlines()) - 1} rows answered, 1 skipped; at 7.9[68] s", said[-2])


def test_after_the_first_few_garbled_rows_the_others_are_counted(lines, monkeypatch, capsys, tmp_path):
    garbled = [line if k == 0 or k % 4 else "?\n" for k, line in enumerate(lines)]
    code, _, said = answers_to(garbled, monkeypatch, capsys, "--out", str(tmp_path / "t.csv"))
    told = [line for line in said if "skipped-row" in line]
    assert [int(re.search(r"line (\d+):", line).group(1)) for line in told] == [5, 9, 13, 17, 21]
    assert [line.endswith("further ones are only counted") for line in told] == [False] * 4 + [True]
    assert (code, said[-1].partition(";")[0]) == (1, "baroarma: 100 rows skipped that could not be read")
    assert len((tmp_path / "t.csv").read_text().splitlines()) > 200


def test_a_stream_without_one_row_that_can_be_read_is_unreadable(lines, monkeypatch, capsys, tmp_path):
    garbled = [lines[0], *["?\n"] * 100]
    code, out, said = answers_to(garbled, monkeypatch, capsys, "--out", str(tmp_path / "t.csv"))
    assert (code, out, list(tmp_path.iterdir())) == (2, "", [])
    assert said[-1].startswith("baroarma: not one row could be read; standard input, line 2: 1 cells, but ")


def test_a_clock_that_goes_backwards_ends_it_but_what_was_answered_stays(lines, tracker, tmp_path, capsys):
    with pytest.raises(ValueError, match="line 83: time must increase"):
        track_live(tracker, [*lines[:81], "?\n", *lines[80:]], str(tmp_path / "t.csv"), None)
    assert len((tmp_path / "t.csv").read_text().splitlines()) == 1 + 80 - ALIGNING
    assert "30 rows answered, 1 skipped" in capsys.readouterr().err


def test_a_plot_is_not_disturbed_by_what_is_told_of_a_garbled_row(lines, tracker, capsys):
    shown, said = plot(), []

    def rows():
        yield from lines[:100]
        yield "?\n"
        yield lines[100]
        said.append(capsys.readouterr().err)

    with pytest.raises(Refusal, match="1 row skipped"):
        track_live(tracker, rows(), None, shown)
    assert said == [""]
    assert "line 101: 1 cells" in capsys.readouterr().err


@pytest.mark.parametrize("count", [1, 2, 30])
def test_rows_that_end_within_the_alignment_leave_no_file(lines, tmp_path, monkeypatch, capsys, count):
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(lines[:count])))
    assert main(["track", "-", "--out", str(tmp_path / "t.csv")]) == 1
    assert "ended within the first second" in capsys.readouterr().err.splitlines()[-1]
    assert not list(tmp_path.iterdir())


def test_without_a_noise_model_it_warns(lines, monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(lines)))
    assert main(["track", "-"]) == 0
    assert "warning (default-noise)" in capsys.readouterr().err


@pytest.mark.parametrize("where", ["-", "file"])
def test_without_a_terminal_it_goes_on_without_the_plot(lines, monkeypatch, capsys, tmp_path, where):
    (tmp_path / "squat.csv").write_text("".join(lines))
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(lines)))
    assert main(["track", "-" if where == "-" else str(tmp_path / "squat.csv"), "--plot"]) == 0
    captured = capsys.readouterr()
    assert "stderr is no terminal to draw on, so there is no plot" in captured.err
    assert captured.out.startswith(HEAD)


def test_a_window_without_a_plot_is_refused(capsys):
    assert main(["track", "-", "--window", "5"]) == 2
    assert "--window belongs to --plot" in capsys.readouterr().err


def plot(window=20.0, **options):
    return LivePlot(Console(file=io.StringIO(), force_terminal=True, width=80, height=24, **options), window)


def test_a_plot_remembers_its_window_and_no_more_however_fast_the_rows_come():
    shown = plot(window=10.0)
    for k in range(50_000):
        shown.take((k * 1e-3, 0.0, 0.0, 1.0, 1.0))
    times = [answer[0] for answer in shown._answers]
    assert len(times) <= 2 * MOST_ROWS
    assert times[-1] == 49.999
    assert times[0] == pytest.approx(39.999, abs=0.02)
    assert np.all(np.diff(times) > 0)


def test_a_plot_of_slow_rows_keeps_each():
    shown = plot(window=10.0)
    for k in range(100):
        shown.take((0.1 * k, 0.0, 0.0, 1.0, 1.0))
    assert len(shown._answers) == 100


def test_before_the_first_answer_a_plot_says_what_it_waits_for():
    assert "the first second, at rest, aligns" in plot().drawing(24).plain


# ---- a terminal of its own, where the system has such


pty = pytest.importorskip("pty", reason="pseudo-terminals are POSIX's")


class Terminal:
    """A program with a terminal of 80 x 24 at its stderr, which is read only when asked to."""

    def __init__(self, *arguments, stdout=subprocess.PIPE, environment=None):
        self.master, side = pty.openpty()
        self.resize(80, 24)
        kept = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
        self.process = subprocess.Popen(
            [*COMMAND, *arguments],
            stdin=subprocess.PIPE,
            stdout=side if stdout == "terminal" else stdout,
            stderr=side,
            text=True,
            bufsize=1,
            env=kept | {"TERM": "xterm-256color", "LC_ALL": "C.UTF-8"} | (environment or {}),
            start_new_session=True,
        )
        os.close(side)
        self.seen = b""
        self.guard = threading.Timer(60, self.process.kill)  # a test that fails shall not hang
        self.guard.start()

    def resize(self, width, height):
        import fcntl
        import struct
        import termios

        fcntl.ioctl(self.master, termios.TIOCSWINSZ, struct.pack("HHHH", height, width, 0, 0))

    def watch(self):
        """Read what is drawn from now on, as a terminal does."""
        self.watcher = threading.Thread(target=self._read)
        self.watcher.start()

    def _read(self):
        try:
            while block := os.read(self.master, 1 << 16):
                self.seen += block
        except OSError:  # Linux's way to say that the other side is closed
            pass

    def send(self, lines):
        for line in lines:
            self.process.stdin.write(line)
            self.process.stdin.flush()

    def until(self, text, seconds=20):
        """Wait for a text on the screen."""
        end = time.monotonic() + seconds
        while text not in self.seen.decode(errors="replace"):
            assert time.monotonic() < end, self.seen[-2000:]
            time.sleep(0.01)

    def end(self):
        """Return the exit code and all that was on the screen."""
        if not self.process.stdin.closed:
            self.process.stdin.close()
        code = self.process.wait()
        self.guard.cancel()
        self.watcher.join(5)
        os.close(self.master)
        if self.process.stdout:
            self.process.stdout.close()
        return code, self.seen.decode()


def plain(screen):
    """Without the control sequences."""
    return re.sub(r"\x1b\[[?\d;]*[A-Za-z]", "", screen).replace("\r", "")


@pytest.fixture
def noise(tmp_path):
    BMP085.noise.save(tmp_path / "noise.json")
    return str(tmp_path / "noise.json")


def test_a_terminal_that_takes_nothing_does_not_hold_up_the_answers(lines, noise):
    """Nobody reads the terminal, as after Ctrl-S, so the thread that draws soon waits for ever."""
    terminal = Terminal("-", "--plot", "--noise", noise)
    answers = []
    for k, line in enumerate(lines[:400]):
        terminal.send([line])
        if k == 0 or k > ALIGNING:
            answers.append(terminal.process.stdout.readline())
        time.sleep(0.004)  # 1.6 s in all: eight drawings, more than a terminal's buffer holds
    assert [float(answer.split(",")[0]) for answer in answers[1:]] == pytest.approx(
        [0.02 * k for k in range(ALIGNING, 399)]
    )
    terminal.watch()
    code, screen = terminal.end()
    assert code == 0
    assert screen.rindex(LEFT) < screen.rindex("349 rows answered")
    assert SHOWN in screen[screen.rindex("\x1b[?25l") :]
    assert "height" in plain(screen[screen.rindex(LEFT) :])  # the last drawing stays


def test_ctrl_c_gives_the_terminal_back_and_keeps_the_rows(lines, noise, tmp_path):
    terminal = Terminal("-", "--plot", "--noise", noise, "--out", str(tmp_path / "t.csv"), stdout="terminal")
    terminal.watch()
    terminal.send(lines[:301])
    terminal.until("at 5.98 s")
    terminal.process.send_signal(signal.SIGINT)
    code, screen = terminal.end()
    assert code == 130
    after = plain(screen[screen.rindex(LEFT) :])
    assert "250 rows answered" in after
    assert "interrupted; no file is half-written" in after
    assert "Traceback" not in screen
    assert SHOWN in screen[screen.rindex("\x1b[?25l") :]
    rows = (tmp_path / "t.csv").read_text().splitlines()
    assert rows[0] == HEAD
    assert len(rows) == 251
    assert {row.count(",") for row in rows} == {4}


def test_on_one_terminal_the_plot_is_shown_instead_of_rows_in_any_size_and_encoding(lines, noise):
    terminal = Terminal(
        "-", "--plot", "--noise", noise, "--window", "3", stdout="terminal",
        environment={"PYTHONIOENCODING": "ascii", "LC_ALL": "C"},
    )  # fmt: skip
    terminal.watch()
    terminal.send(lines[:101])
    terminal.until("at 1.98 s")
    terminal.resize(40, 12)
    terminal.send(lines[101:201])
    terminal.until("at 3.98 s")
    time.sleep(0.3)  # one more drawing
    code, screen = terminal.end()
    assert code == 0
    assert screen.isascii()
    assert HEAD not in screen
    last = plain(screen[: screen.rindex(LEFT)].rpartition("\x1b[H")[2]).split("\n")
    assert len(last) == 12
    assert max(map(len, last)) <= 40
    assert "1 s" not in last[-1]  # 3 s before 3.98 s


def test_a_finished_track_is_drawn_on_the_terminal_and_stdout_stays_csv(lines, noise, tmp_path):
    (tmp_path / "squat.csv").write_text("".join(lines))
    terminal = Terminal(str(tmp_path / "squat.csv"), "--plot", "--noise", noise)
    terminal.watch()
    table = terminal.process.stdout.read()
    code, screen = terminal.end()
    assert code == 0
    assert table.startswith(HEAD)
    assert table.count("\n") == 401
    assert any(0x2800 < ord(character) < 0x2900 for character in screen)
    assert "next: baroarma compare" in screen
