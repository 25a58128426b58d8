"""`baroarma completion`: names, options and files at the press of Tab."""

from __future__ import annotations

import click

from baroarma.cli.common import json_option, print_json
from baroarma.cli.loudness import say

WHERE = {
    "bash": "baroarma completion bash > ~/.local/share/bash-completion/completions/baroarma",
    "zsh": "baroarma completion zsh > ~/.zfunc/_baroarma  (a folder of $fpath, before compinit)",
    "fish": "baroarma completion fish > ~/.config/fish/completions/baroarma.fish",
}
"""How each shell finds the script from its next start on."""


@click.command(
    short_help="Print the script for completion by Tab.",
    epilog="Example, for this shell only:  source <(baroarma completion bash)",
)
@click.argument("shell", type=click.Choice(list(WHERE)))
@json_option
@click.pass_context
def completion(context: click.Context, shell: str, as_json: bool) -> None:
    """Print the script that completes commands, options, names and files for a SHELL."""
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None
    script = kind(context.find_root().command, {}, "baroarma", "_BAROARMA_COMPLETE").source()
    if as_json:
        print_json({"shell": shell, "script": script})
        return
    click.echo(script)
    say(f"next: {WHERE[shell]}")
