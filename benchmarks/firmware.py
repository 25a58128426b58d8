"""What exported firmware costs, and how near to Python it is: `python benchmarks/firmware.py [FOLDER]`.

Needs gcc; valgrind for instructions, arm-none-eabi-gcc with newlib for flash and RAM of Cortex-M.  FOLDER
holds real recordings (default: ../shared/data beside the project); without it they are left out.
"""

import argparse
import io
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

import baroarma as ba
from baroarma.export.firmware import exportable, firmware
from baroarma.formats import write_csv
from baroarma.simulation import BMP085, MOTIONS, simulate

REAL = {
    **{
        name: (f"stampfly_tof_handheld/{name}",)
        for name in ("lift30cm_a", "lift30cm_b", "setdown_c", "air_d")
    },
    "elevator": tuple(f"srp_altimu10_elevator_rocket/elevator_{s}" for s in ("baro", "acc", "gyr")),
}
CORES = {
    "Cortex-M0+": ["-mcpu=cortex-m0plus"],
    "Cortex-M4F": ["-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"],
    "Cortex-M7": ["-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard"],
}
SMALL = ["-std=c99", "-Os", "-mthumb", "-ffunction-sections", "-fdata-sections"]
USER = """
#include "baroarma.h"
volatile baroarma_real sensor[8];
baroarma_state state;
int main(void)
{
    baroarma_init(&state);
    for (;;) {
        const baroarma_real accel[3] = {sensor[0], sensor[1], sensor[2]};
        const baroarma_real gyro[3] = {sensor[3], sensor[4], sensor[5]};
        sensor[0] = baroarma_step(&state, accel, gyro, sensor[6], sensor[7]).height;
    }
}
"""
IDLE = "volatile float sensor[8]; int main(void) { for (;;) sensor[0] = sensor[1]; }"


def run(*command, **options):
    return subprocess.run([*map(str, command)], check=True, capture_output=True, text=True, **options).stdout


def export(folder, preset, real, rate_hz):
    firmware(preset, noise=BMP085.noise, rate_hz=rate_hz, real=real).write(folder)
    return folder


ROOM = "-DBAROARMA_EARLY_ROWS=200"
"""Room for every row of the alignment's second, whatever its clock."""


def replay(folder, recording, *options):
    """The track that the firmware makes of a recording."""
    run("gcc", "-O2", "-DBAROARMA_REPLAY", *options, *folder.glob("*.c"), "-lm", "-o", folder / "replay")
    write_csv(recording, folder / "recording.csv")
    with open(folder / "recording.csv") as rows:
        return pd.read_csv(io.StringIO(run(folder / "replay", stdin=rows)))


def alignment_rate(recording):
    """Rate of the barometer in the first second, as the tracker takes it."""
    t = recording.t[recording.is_new]
    t = t[t - recording.t[0] < 1 - 5e-7]
    return (len(t) - 1) / (t[-1] - t[0])


def rides(folder):
    yield from ((name, simulate(name, seed=1)) for name in MOTIONS)
    if folder.is_dir():
        yield from (
            (name, ba.read(*(folder / f"{stream}.csv.gz" for stream in streams)))
            for name, streams in REAL.items()
        )


def print_nearness(work, folder):
    presets = exportable()
    print(f"| recording | {' | '.join(presets)} |\n|---|{'---|' * len(presets)}")
    for name, recording in rides(folder):
        cells = []
        for preset in presets:
            track = ba.Tracker.preset(preset, noise=BMP085.noise).run(recording)
            off = []
            for real in ("double", "float"):
                made = export(work / f"{preset}-{real}", preset, real, alignment_rate(recording))
                off.append(np.abs(replay(made, recording, ROOM)["height_m"].to_numpy() - track.height).max())
            cells.append("{:.0e} / {:.0e}".format(*off))
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def instructions(folder):
    """Instructions of one step on this computer, by callgrind."""
    recording = simulate("squat", duration=20, seed=1)
    replay(folder, recording)
    options = ("--toggle-collect=baroarma_step", f"--callgrind-out-file={folder / 'callgrind.out'}")
    with open(folder / "recording.csv") as rows:
        command = ["valgrind", "--tool=callgrind", *options, folder / "replay"]
        log = subprocess.run(
            [*map(str, command)], check=True, capture_output=True, text=True, stdin=rows
        ).stderr
    return int(re.search(r"Collected : (\d+)", log)[1]) / len(recording)


def size(folder, core, name, source):
    """Flash and RAM of a linked program, bytes."""
    (folder / "user").mkdir(exist_ok=True)
    (folder / "user" / f"{name}.c").write_text(source)
    sources = [folder / "user" / f"{name}.c", *([folder / "baroarma.c"] if name == "user" else [])]
    program = folder / "user" / f"{name}.elf"
    link = ["--specs=nano.specs", "--specs=nosys.specs", "-Wl,--gc-sections", "-lm"]
    run("arm-none-eabi-gcc", *SMALL, *CORES[core], "-I", folder, *sources, *link, "-o", program)
    text, data, bss = map(int, run("arm-none-eabi-size", program).splitlines()[1].split()[:3])
    return text + data, data + bss


def stack(folder, core):
    """Bytes of stack below baroarma_step along the deepest path, without the math library's own."""
    output = folder / "user" / "baroarma.o"
    flags = [*SMALL, *CORES[core], "-fcallgraph-info=su", "-c", folder / "baroarma.c", "-o", output]
    run("arm-none-eabi-gcc", *flags)
    graph = output.with_suffix(".ci").read_text()
    own = {m[1]: int(m[2]) for m in re.finditer(r'node: { title: "([^"]+)".*?(\d+) bytes', graph)}
    calls = re.findall(r'edge: { sourcename: "([^"]+)" targetname: "([^"]+)"', graph)

    def depth(function):
        return own.get(function, 0) + max((depth(b) for a, b in calls if a == function), default=0)

    return depth("baroarma_step")


def print_costs(work):
    print("| preset | type | instructions a step |", end="")
    print("".join(f" {core}: flash, of it ours / state / stack |" for core in CORES))
    print(f"|---|---|---|{'---|' * len(CORES)}")
    for preset in exportable():
        for real in ("float", "double"):
            folder = export(work / f"cost-{preset}-{real}", preset, real, 50)
            cells = [f"{instructions(folder):.0f}" if shutil.which("valgrind") else "–"]
            cells += [cost(folder, core) for core in CORES] if shutil.which("arm-none-eabi-gcc") else []
            print(f"| {preset} | {real} | {' | '.join(cells)} |", flush=True)


def cost(folder, core):
    flash, ram = size(folder, core, "user", USER)
    idle_flash, idle_ram = size(folder, core, "idle", IDLE)
    deep = stack(folder, core)
    ours = int(run("arm-none-eabi-size", folder / "user" / "baroarma.o").splitlines()[1].split()[0])
    return f"{flash - idle_flash}, {ours} / {ram - idle_ram} / {deep}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    beside = Path(__file__).resolve().parents[2] / "shared" / "data"
    parser.add_argument("folder", nargs="?", type=Path, default=beside)
    folder = parser.parse_args().folder
    with tempfile.TemporaryDirectory() as work:
        print("Largest difference of height from Python, m, double / float:\n")
        print_nearness(Path(work), folder)
        print("\nBytes, and instructions on this computer:\n")
        print_costs(Path(work))


if __name__ == "__main__":
    main()
