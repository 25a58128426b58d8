"""The command line: `baroarma COMMAND ...`.

Exit codes: 0 done; 1 the data don't support the request (the verdict says why and what to do, and no output
file is written); 2 unreadable input or wrong usage.  Every failure is one plain sentence on stderr.  Results
go to stdout, all else to stderr; with ``--json`` stdout is one JSON document.

The modules behind the commands import what they need when they run, so that ``--help`` answers at once.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import click

from baroarma import __version__
from baroarma.cli.calibrate import calibrate
from baroarma.cli.common import Refusal
from baroarma.cli.compare import compare
from baroarma.cli.convert import convert
from baroarma.cli.demo import demo
from baroarma.cli.experiment import experiment
from baroarma.cli.export import export
from baroarma.cli.identify import identify
from baroarma.cli.predict import predict
from baroarma.cli.simulate import simulate
from baroarma.cli.track import track
from baroarma.cli.whiten import whiten


@click.group(
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Start with: baroarma identify rest.csv --out noise.json --report page.html",
    invoke_without_command=True,
)
@click.version_option(__version__, prog_name="baroarma")
@click.pass_context
def cli(context: click.Context) -> None:
    """From a barometer at rest to a noise model, a whitening filter, and height and vertical velocity."""
    if context.invoked_subcommand is None:
        raise click.UsageError("give a command, such as identify", context)


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
):
    cli.add_command(command)


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
    except (click.Abort, KeyboardInterrupt):
        return _fail("interrupted; nothing was written", 130)
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx else "baroarma"
        return _fail(f"{error.format_message().rstrip('.')}; see {command} --help", 2)
    except click.ClickException as error:
        return _fail(error.format_message(), 2)
    except SystemExit:  # click's answer when the reader of our output has gone, as `head` does
        return 0
    except OSError as error:
        return _fail(f"{error.filename or 'the system'}: {error.strerror or error}", 2)
    except ValueError as error:
        return _fail(str(error), 2)
    return 0


def entry_point() -> None:
    """Run the command line as a program."""
    sys.exit(main())


def _fail(message: str, code: int) -> int:
    click.echo(f"baroarma: {' '.join(message.split())}", err=True)
    return code
