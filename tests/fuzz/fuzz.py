"""Fuzz readers and commands: ``python tests/fuzz/fuzz.py --runs 100000 --seed 1`` (or ``make fuzz``).

With atheris installed (``pip install 'baroarma[fuzz]'``, Linux) the inputs that reach new code are kept and
broken further; without it they are all drawn from the seeds.  Inputs that break a promise are kept in the
folder ``--out``, whose ``failures.txt`` says what was promised; the exit code is 1.  ``--again FILE`` repeats
one.
"""

import argparse
import collections
import hashlib
import json
import math
import re
import sys
import tempfile
import time
from pathlib import Path

import fuzz_mutations
import fuzz_seeds

HEAD = 2
"""Bytes before an input's content: which kind of file it is, and which command it is given to."""


class Session:
    """Run inputs, count what became of them, and keep those that break a promise."""

    def __init__(self, targets, folder, kept, runs, kinds):
        self.targets, self.folder, self.kept, self.runs, self.kinds = targets, folder, kept, runs, kinds
        self.counts = collections.Counter()
        self.slowest = collections.defaultdict(float)
        self.failures = {}
        self.done, self.start = 0, time.time()

    def take(self, packed):
        """Run one input: two bytes that choose, then the content."""
        kind, command, data = self.unpacked(packed)
        try:
            outcome = self.targets.run(kind, command, data, self.folder)
            self.counts[kind, command, outcome.code] += 1
            self.slowest[kind] = max(self.slowest[kind], outcome.seconds)
        except self.targets.Broken as broken:
            self.counts[kind, command, "broken"] += 1
            self._keep(kind, command, packed, str(broken))
        self.done += 1
        if self.done % 1000 == 0 or self.done == self.runs:
            self.write()

    def unpacked(self, packed):
        """Return kind, command and content of an input."""
        kind = self.kinds[packed[0] % len(self.kinds)] if packed else self.kinds[0]
        choices = self.targets.commands(kind)
        return (
            kind,
            choices[packed[1] % len(choices)] if len(packed) > 1 else choices[0],
            bytes(packed[HEAD:]),
        )

    def _keep(self, kind, command, packed, why):
        signature = f"{kind} {command}: " + re.sub(r"[0-9.e+-]{3,}|/[^ :]*/", "#", why)
        if signature not in self.failures:
            name = hashlib.sha1(packed).hexdigest()[:12] + f".{kind}"
            (self.kept / name).write_bytes(packed)
            self.failures[signature] = f"{name} {command}: {why}"
            print(f"BROKEN {self.failures[signature]}", file=sys.__stderr__, flush=True)

    def write(self):
        """Write the counts so far."""
        table = {}
        for (kind, command, code), n in sorted(self.counts.items(), key=str):
            table.setdefault(kind, {}).setdefault(command, {})[str(code)] = n
        document = {"inputs": self.done, "seconds": round(time.time() - self.start), "counts": table}
        document["slowest_s"] = {kind: round(seconds, 3) for kind, seconds in self.slowest.items()}
        (self.kept / "counts.json").write_text(json.dumps(document, indent=1) + "\n")
        (self.kept / "failures.txt").write_text("".join(f"{line}\n" for line in self.failures.values()))
        rate = self.done / max(time.time() - self.start, 1e-9)
        print(
            f"{self.done} inputs, {rate:.0f}/s, {len(self.failures)} failures",
            file=sys.__stderr__,
            flush=True,
        )

    def mutated(self, packed, largest, seed):
        """Return an input broken: mostly its content, at times which command it is given to."""
        rng = fuzz_mutations.generator(seed)
        kind, _, data = self.unpacked(packed)
        if len(packed) <= HEAD or rng.random() < 0.3:
            return self.fresh(rng)[:largest]
        which = packed[1] if rng.random() < 0.7 else rng.randrange(256)
        return bytes([packed[0], which]) + fuzz_mutations.mutated(kind, data, rng)[: largest - HEAD]

    def fresh(self, rng):
        """Return a broken seed of any kind."""
        which = rng.randrange(len(self.kinds))
        return bytes([which, rng.randrange(256)]) + fuzz_mutations.random_input(self.kinds[which], rng)


def main():
    """Run as the arguments say."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=100_000, help="inputs in total; default: 100000")
    parser.add_argument("--seed", type=int, default=1, help="which inputs; default: 1")
    parser.add_argument("--out", type=Path, default=Path("build/fuzz"), help="folder for counts and failures")
    parser.add_argument(
        "--no-coverage", action="store_true", help="draw from the seeds, though atheris is there"
    )
    parser.add_argument("--kinds", help="only these kinds of files, such as csv,zip")
    parser.add_argument("--again", type=Path, help="run one kept input and show what it does")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    atheris = None if given.no_coverage or given.again else _atheris()
    targets = _targets(atheris)
    with tempfile.TemporaryDirectory(dir=targets.quick_folder()) as folder:
        kinds = fuzz_seeds.available() if given.kinds is None else tuple(given.kinds.split(","))
        session = Session(targets, folder, given.out, given.runs, kinds)
        if given.again:
            kind, command, data = session.unpacked(given.again.read_bytes())
            print(kind, command, targets.run(kind, command, data, folder))
            return 0
        _warm_up(session)
        targets.limit_memory()
        if atheris is None:
            rng = fuzz_mutations.generator(given.seed)
            while session.done < given.runs:
                session.take(session.fresh(rng))
        else:
            _guided(atheris, session, given)
        return 1 if session.failures else 0


def _atheris():
    try:
        import atheris
    except ImportError:
        print("atheris is not installed: inputs are drawn without regard to coverage", file=sys.stderr)
        return None
    return atheris


def _targets(atheris):
    """Import what is tested, with its branches counted; not the kernels, which numba compiles itself."""
    if atheris is not None:
        with atheris.instrument_imports(include=["baroarma.formats", "baroarma.noise_file", "baroarma.cli"]):
            from baroarma import cli, noise_file  # noqa: F401
            from baroarma.formats import ardupilot, csv, long, parquet, phone, rosbag, rows, ulog  # noqa: F401
    import fuzz_targets

    return fuzz_targets


def _warm_up(session):
    """Run every healthy seed by every command once: what is compiled then is not what is measured."""
    for kind in session.kinds:
        for command in sorted(set(session.targets.commands(kind))):
            for data in fuzz_seeds.seeds(kind):
                session.targets.run(kind, command, data, session.folder, longest=300, most_memory=math.inf)


def _guided(atheris, session, given):
    """Let libFuzzer choose what to break further; it never returns."""
    with tempfile.TemporaryDirectory() as corpus:
        for which, kind in enumerate(session.kinds):
            for k, data in enumerate(fuzz_seeds.seeds(kind)):
                (Path(corpus) / f"{kind}-{k}").write_bytes(bytes([which, k]) + data)
        options = [
            f"-seed={given.seed}",
            f"-max_len={fuzz_mutations.LARGEST}",
            "-len_control=0",
            "-timeout=60",
        ]
        options += [
            f"-atheris_runs={given.runs}",
            f"-artifact_prefix={given.out}/",
            "-rss_limit_mb=4096",
            "-verbosity=0",
        ]
        options += ["-mutate_depth=1"]
        atheris.Setup([sys.argv[0], *options, corpus], session.take, custom_mutator=session.mutated)
        atheris.Fuzz()


if __name__ == "__main__":
    sys.exit(main())
