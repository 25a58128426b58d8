"""The command line: `baroarma COMMAND ...`.

Exit codes: 0 done; 1 the data don't support the request (the verdict says why and what to do, and no output
file is written), or rows of a stream were skipped; 2 unreadable input or wrong usage; 130 interrupted by
Ctrl-C, 143 by SIGTERM.  Every failure is one plain sentence on stderr.  Results go to stdout, all else to
stderr; with ``--json`` stdout is one JSON document.

The modules behind the commands import what they need when they run, so that ``--help`` answers at once.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from types import FrameType

import click

from baroarma.cli.calibrate import calibrate
from baroarma.cli.common import Refusal
from baroarma.cli.compare import compare
from baroarma.cli.completion import completion
from baroarma.cli.convert import convert
from baroarma.cli.demo import demo
from baroarma.cli.experiment import experiment
from baroarma.cli.export import export
from baroarma.cli.identify import identify
from baroarma.cli.loudness import loudness_options, versions
from baroarma.cli.predict import predict
from baroarma.cli.simulate import simulate
from baroarma.cli.track import track
from baroarma.cli.whiten import whiten


class InOrder(click.Group):
    """Commands as one needs them, not by the alphabet."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands in the order in which they were added."""
        return list(self.commands)


@click.group(
    cls=InOrder,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Start with:  baroarma identify rest.csv --out noise.json --report page.html",
    invoke_without_command=True,
)
@click.option("--version", is_flag=True, help="Print the versions of baroarma and what it rests on.")
@click.pass_context
def cli(context: click.Context, version: bool) -> None:
    """From a barometer at rest to a noise model, a whitening filter, and height and vertical velocity."""
    if version:
        click.echo(versions())
        context.exit()
    if context.invoked_subcommand is None:
        raise click.UsageError("give a command, such as identify", context)


cli.params += loudness_options()
for command in (
    identify,
    whiten,
    track,
    compare,
    predict,
    calibrate,
    convert,
    simulate,
    experiment,
    export,
    demo,
    completion,
):
    command.params += loudness_options()
    cli.add_command(command)


class Terminated(KeyboardInterrupt):
    """Another program ends this one, as `timeout` does: what is half-written goes, as after Ctrl-C."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command in this process.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; default: those of the process.

    Returns
    -------
    int
        The exit code (module docstring).
    """
    try:
        cli.main(args=None if argv is None else list(argv), prog_name="baroarma", standalone_mode=False)
    except Refusal as refusal:
        return _fail(str(refusal), 1)
    except click.exceptions.Exit as done:
        return done.exit_code
    except (click.Abort, KeyboardInterrupt) as stop:
        return _stopped(stop.__cause__ or stop)
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx else "baroarma"
        return _fail(f"{error.format_message().rstrip('.')}; see {command} --help", 2)
    except click.ClickException as error:
        return _fail(error.format_message(), 2)
    except SystemExit:  # click's answer when the reader of our output has gone, as `head` does
        return 0
    except OSError as error:
        return _fail(f"{error.filename or 'the system'}: {error.strerror or error}", 2)
    except MemoryError as error:
        return _fail(f"there is not enough memory; try less at a time ({error})", 2)
    except ValueError as error:
        return _fail(str(error), 2)
    return 0


def entry_point() -> None:
    """Run the command line as a program."""
    signal.signal(signal.SIGTERM, _terminate)
    sys.exit(_flushed(main()))


def _terminate(number: int, frame: FrameType | None) -> None:
    raise Terminated


def _flushed(code: int) -> int:
    """Bring the last of stdout to its reader, who may have gone, or to a disk, which may be full."""
    try:
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            return _fail(f"the output can't be written: {error.strerror}", 2)
    return code


def _stopped(why: BaseException) -> int:
    if isinstance(why, Terminated):
        return _fail("terminated; no file is half-written", 143)
    return _fail("interrupted; no file is half-written", 130)


def _fail(message: str, code: int) -> int:
    click.echo(f"baroarma: {' '.join(message.split())}", err=True)
    return code
