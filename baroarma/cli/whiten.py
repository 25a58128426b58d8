"""`baroarma whiten`: a noise model in, whitening coefficients out."""

from __future__ import annotations

import click

from baroarma.cli.common import OutputFile, json_option, write_text
from baroarma.cli.loudness import say, say_next
from baroarma.cli.names import InputFile


@click.command(
    short_help="Synthesise a whitening filter.",
    epilog="Example:  baroarma whiten noise.json --rate 50 --unity-gain-at 25 --format c --out whitening.c",
)
@click.argument("noise", required=False, type=InputFile(), metavar="[NOISE.json]")
@click.option(
    "--arma", nargs=2, type=float, metavar="A B", help="ARMA(1,1): y[k] + A y[k-1] = e[k] + B e[k-1]."
)
@click.option("--interval", type=float, metavar="S", help="arma: interval at which A and B hold, in s.")
@click.option(
    "--rate", type=float, metavar="HZ", help="Rate at which the filter will run; default: the model's."
)
@click.option(
    "--unity-gain-at", type=float, metavar="HZ", help="Frequency with gain 1, 0 to Nyquist; default: Nyquist."
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["json", "csv", "c", "cmsis", "q15", "q31"]),
    default="json",
    show_default=True,
    help="Coefficients as JSON, CSV, a C99 function, a CMSIS-DSP biquad or C99 in fixed point.",
)
@click.option("--out", type=OutputFile(), help="Write to this file instead of stdout.")
@json_option
def whiten(
    noise: str | None,
    arma: tuple[float, float] | None,
    interval: float | None,
    rate: float | None,
    unity_gain_at: float | None,
    form: str,
    out: str | None,
    as_json: bool,
) -> None:
    """Print the whitening filter of a noise model, or of an ARMA(1,1) as in Sabatini & Genovese 2013."""
    from baroarma.arma import ArmaModel
    from baroarma.export import render
    from baroarma.noise_model import NoiseModel

    if as_json and form != "json":
        raise click.UsageError(f"--json and --format {form} exclude each other")
    if (noise is None) == (arma is None):
        raise click.UsageError("give either a NOISE.json or --arma A B with --interval")
    if noise is not None:
        if interval is not None:
            raise click.UsageError("--interval belongs to --arma")
        model = NoiseModel.load(noise)
        whitening = model.whitening_filter(rate_hz=rate, unity_gain_hz=unity_gain_at)
    else:
        assert arma is not None
        if interval is None or rate is None:
            raise click.UsageError("--arma needs --interval and --rate")
        unity_gain_hz = rate / 2 if unity_gain_at is None else unity_gain_at
        ar_ma = ArmaModel(ar=(arma[0],), ma=(arma[1],), sd=1.0, dt=interval)
        whitening = ar_ma.whitening_filter(rate_hz=rate, unity_gain_hz=unity_gain_hz)
    text = render(whitening, "json" if as_json else form)
    if out:
        write_text(out, text)
    else:
        click.echo(text, nl=False)
    if arma is not None and arma[1] <= arma[0]:
        say(
            f"warning: B = {arma[1]:g} is not above A = {arma[0]:g}, so this is no Gauss-Markov plus white "
            "noise; are the two swapped?"
        )
    if whitening.note:
        say(whitening.note)
    elif abs(whitening.dc_gain - 1) > 1e-9:
        say(
            f"note: a steady height change will be reported {whitening.dc_gain:.4g} times its size (DC gain)."
        )
    if as_json:
        return
    if noise is None:
        say_next("identify", "REST.csv", "--out", "noise.json")
    else:
        say_next("track", "RECORDING.csv", "--noise", noise, "--preset", "sg14-b")
