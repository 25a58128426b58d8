"""`baroarma predict`: accuracy before any experiment."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from baroarma.cli.common import OutputFile, json_option, noise_option, print_json
from baroarma.cli.loudness import say, say_next
from baroarma.cli.names import NAMES, Listing, Name, preset_titles

if TYPE_CHECKING:
    from baroarma.imu_noise import ImuNoise
    from baroarma.predicted import Prediction


@click.command(
    cls=Listing,
    lists={"Presets": preset_titles, "Devices": NAMES["device"]},
    short_help="Predict the accuracy before any experiment.",
    epilog="Example:  baroarma predict --noise noise.json --imu wimu --duration 600",
)
@noise_option(is_required=True)
@click.option(
    "--preset",
    type=Name("preset"),
    default="baroarma",
    show_default=True,
    help="One of those below.",
)
@click.option(
    "--imu",
    type=Name("device", "DEVICE|REST.csv", or_file=True),
    default="simple",
    show_default=True,
    help="A device, or a recording of the IMU at rest.",
)
@click.option(
    "--duration", type=float, default=180.0, show_default=True, metavar="S", help="Length of the run, in s."
)
@click.option(
    "--horizontal-acceleration",
    type=float,
    default=0.0,
    show_default=True,
    metavar="A",
    help="Its rms in m/s², 1 when walking: tilt errors bring it into the vertical.",
)
@click.option("--tune", "tuned", is_flag=True, help="Find the gains that minimise the velocity's true error.")
@click.option("--plot", type=OutputFile(), metavar="FILE", help="Draw the sds over time: .png, .svg or .pdf.")
@json_option
def predict(
    noise_file: str,
    preset: str,
    imu: str,
    duration: float,
    horizontal_acceleration: float,
    tuned: bool,
    plot: str | None,
    as_json: bool,
) -> None:
    """Predict the sds of height and vertical velocity of a preset from the noise of its sensors."""
    from baroarma.noise_model import NoiseModel
    from baroarma.prediction import predict_accuracy
    from baroarma.tuning import tune

    noise, sensors = NoiseModel.load(noise_file), _imu(imu)
    if tuned:
        tuning = tune(
            preset, noise, sensors, duration=duration, horizontal_acceleration=horizontal_acceleration
        )
        text, document, prediction = tuning.summary(), tuning.to_dict(), tuning.after
    else:
        prediction = predict_accuracy(
            noise, sensors, preset, duration, horizontal_acceleration=horizontal_acceleration
        )
        text, document = prediction.summary(), prediction.to_dict()
    if plot:
        _draw(prediction, plot)
        say(f"plot: {plot}")
    if as_json:
        print_json(document)
        return
    click.echo(text)
    if tuned:
        say_next("track", "RECORDING.csv", "--noise", noise_file, "--preset", preset)
    else:
        say_next("predict", "--noise", noise_file, "--preset", preset, "--imu", imu, "--tune")


def _imu(name: str) -> ImuNoise:
    """Return a device's IMU by its name, else what a recording of it shows."""
    from pathlib import Path

    from baroarma.formats import read
    from baroarma.imu_noise import ImuNoise
    from baroarma.simulation import DEVICES

    if name in DEVICES:
        return ImuNoise.of_device(name)
    if not Path(name).exists():
        raise click.UsageError(f"--imu {name} is no file and no device; devices are {', '.join(DEVICES)}")
    return ImuNoise.from_recording(read(name))


def _draw(prediction: Prediction, path: str) -> None:
    from pathlib import Path

    from matplotlib.figure import Figure

    from baroarma.atomic import replacing

    figure = Figure(figsize=(7, 4), layout="constrained")
    prediction.plot(figure.subplots())
    with replacing(path) as temporary:
        figure.savefig(temporary, format=Path(path).suffix.removeprefix(".") or "png")
