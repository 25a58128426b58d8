"""How inputs are broken: bytes, cells, lines, columns, keys; within what is packed, too."""

import gzip
import io
import json
import random
import struct
import warnings
import zipfile
import zlib

import fuzz_seeds

TOKENS = [
    *b"nan NaN inf -inf Infinity 1e400 -1e400 1e5000 1e308 -1e308 1e-320 0x10 1_000 1,5 1.5.2 --1 +1".split(),
    *b'0 -0 1e 99999999999999999999 null true # // \' ; , | %s %n <script> =1+1 @SUM(1) " "" \\'.split(),
    *(
        b"",
        b" ",
        b"\t",
        b"\r",
        b"\n",
        b"\r\n",
        b"\n\n\n",
        b"\0",
        b"\xff",
        b"\xfe\xff",
        b"\xef\xbb\xbf",
        b"\x1b[31m",
    ),
    *(text.encode() for text in ("½", "１２", "\u2028", "\U0001f600", "a" * 300)),
    "°".encode("latin-1"),
]
NAMES = (
    b"time_s pressure_pa pressure_hpa altitude_m acc_x_g acc_x_m_s2 gyr_x_deg_s temperature_c ref_height_m"
).split()
NUMBERS = (
    0,
    1,
    -1,
    0x7F,
    0x80,
    0xFF,
    0x7FFF,
    0x8000,
    0xFFFF,
    0x7FFFFFFF,
    0x80000000,
    0xFFFFFFFF,
    1 << 40,
    1 << 63,
)
VALUES = (
    None, True, False, 0, -1, 1e-320, 1e308, -0.0, 10**400, "", "x", "nan", [], {}, [1], [[[]]], {"a": {}},
    float("nan"), float("inf"), "1", "\ud800", "*/", "</script>", 2, 3.5,
)  # fmt: skip
LARGEST = 1 << 17
"""Bytes of a mutated input."""


def mutated(kind, data, rng):
    """Return the input broken in one to four places."""
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        data = rng.choice(MUTATORS.get(kind, (_bytes,)))(data, rng)
    return data[:LARGEST]


def _bytes(data, rng):
    data = bytearray(data or b"\0")
    where, size = rng.randrange(len(data)), rng.choice((1, 2, 4, 8, 64, 1024))
    match rng.randrange(8):
        case 0:
            data[where] ^= 1 << rng.randrange(8)
        case 1:
            data[where] = rng.randrange(256)
        case 2:
            del data[where : where + size]
        case 3:
            data[where:where] = data[where : where + size] * rng.choice((1, 2, 8))
        case 4:
            del data[where:]
        case 5:
            data[where:where] = rng.choice(TOKENS)
        case 6:
            width = rng.choice("BHIQ")
            number = struct.pack("<" + width, rng.choice(NUMBERS) % (1 << 8 * struct.calcsize(width)))
            data[where : where + len(number)] = number
        case 7:
            other = rng.randrange(len(data))
            data[where : where + size] = data[other : other + size]
    return bytes(data)


def _cell(data, rng):
    separator = max(b",;\t", key=data[:200].count)
    lines = data.split(b"\n")
    k = rng.randrange(len(lines))
    cells = lines[k].split(bytes([separator]))
    j = rng.randrange(len(cells))
    cells[j] = rng.choice((rng.choice(TOKENS), _digits(cells[j], rng), b'"' + cells[j] + b'"'))
    lines[k] = bytes([separator]).join(cells)
    return b"\n".join(lines)


def _digits(cell, rng):
    return bytes(rng.choice(b"0123456789.-e") if rng.random() < 0.3 else byte for byte in cell)


def _line(data, rng):
    lines = data.split(b"\n")
    k, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(5):
        case 0:
            lines[k], lines[j] = lines[j], lines[k]
        case 1:
            lines[k:k] = [lines[j]] * rng.choice((1, 2, 30))
        case 2:
            del lines[k : k + rng.choice((1, 3, 100))]
        case 3:
            lines[k] = rng.choice(TOKENS) * rng.choice((1, 3))
        case 4:
            lines[k] = lines[k][: rng.randrange(len(lines[k]) + 1)]
    return rng.choice((b"\n", b"\n", b"\n", b"\r\n", b"\r")).join(lines)


def _column(data, rng):
    """Swap, drop, double or rename a whole column."""
    separator = bytes([max(b",;\t", key=data[:200].count)])
    rows = [line.split(separator) for line in data.split(b"\n")]
    width = len(rows[0])
    k, j, what = rng.randrange(width), rng.randrange(width), rng.randrange(4)
    for row in rows:
        if len(row) == width:
            if what == 0:
                row[k], row[j] = row[j], row[k]
            elif what == 1:
                del row[k]
            elif what == 2:
                row[j:j] = [row[k]]
    if what == 3:
        rows[0][k] = rng.choice((*NAMES, *TOKENS))
    return b"\n".join(map(separator.join, rows))


def _numbers(data, rng):
    """Change numbers within what a reader takes: what survives it reaches the estimators."""
    separator = bytes([max(b",;\t", key=data[:200].count)])
    head, *rows = data.rstrip(b"\n").split(b"\n")
    cells = [row.split(separator) for row in rows]
    column, what = rng.randrange(head.count(separator) + 1), rng.randrange(7)
    factor, constant = 10.0 ** rng.randrange(-9, 10), rng.choice((0.0, 1.0, -1.0, 101325.0, 1e5, 1e-9, 250.0))
    if what == 0:
        cells = cells[:: rng.choice((2, 5, 20))]
    elif what == 1:
        cells = cells[: rng.randrange(len(cells) + 1)]
    for row in cells[rng.randrange(len(cells)) if cells and rng.random() < 0.5 else 0 :]:
        try:
            value = float(row[column])
        except (ValueError, IndexError):
            continue
        new = {2: value * factor, 3: value + factor, 4: constant, 5: -value}.get(what, value)
        if what == 6:
            new = value if rng.random() < 0.7 else rng.choice((None, value + factor, constant))
        row[column] = b"" if new is None else repr(new).encode()
    return b"\n".join([head, *map(separator.join, cells)]) + b"\n"


def _gzip(data, rng):
    """Break the text within, or the end of the packed data."""
    try:
        text = gzip.decompress(data)
    except (OSError, EOFError, zlib.error):
        return _bytes(data, rng)
    return gzip.compress(rng.choice(TEXT)(text, rng)[:LARGEST], 1, mtime=0)


def _zip(data, rng):
    """Break one of the files within, or its name."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            files = {member.filename: archive.read(member) for member in archive.infolist()}
    except Exception:  # what a broken zip raises is not the question here
        return _bytes(data, rng)
    name = rng.choice(sorted(files) or [""])
    text = files.pop(name, b"")
    if rng.random() < 0.2:
        name = rng.choice(
            ("../a.csv", "/abs.csv", "Gravity.csv", "a/" + name, "\n.csv", "x" * 240 + ".csv", name * 2)
        )
    else:
        text = rng.choice(TEXT)(text, rng)
    return fuzz_seeds.packed({**files, name: text[:LARGEST]})


def _frame(data, rng):
    """Change the kind of a Parquet column, its name or a cell."""
    import pandas as pd

    kinds = ("float32", "int64", "str", "bool", "category", "object")
    try:
        frame = pd.read_parquet(io.BytesIO(data))
        column, row = rng.choice(list(frame.columns)), rng.randrange(len(frame))
        with warnings.catch_warnings(action="ignore"):
            match rng.randrange(5):
                case 0:
                    frame[column] = frame[column].astype(rng.choice(kinds))
                case 1:
                    frame[column] = pd.to_datetime(frame[column], unit="s")
                case 2:
                    frame = frame.rename(columns={column: rng.choice((*NAMES, b"a.b", b"")).decode()})
                case 3:
                    frame.loc[row, column] = rng.choice((float("nan"), float("inf"), -1e308, 1e308, 0))
                case 4:
                    frame[column] = frame[column] * 10.0 ** rng.randrange(-9, 10)
            return frame.to_parquet(index=False)
    except Exception:  # not every column can become everything
        return _bytes(data, rng)


def _key(data, rng):
    """Set, drop or double a key of a JSON document, at any depth."""
    try:
        document = json.loads(data)
        at = document
        while isinstance(at, dict | list) and at:
            key = rng.choice(list(at)) if isinstance(at, dict) else rng.randrange(len(at))
            if not (isinstance(at[key], dict | list) and at[key] and rng.random() < 0.7):
                break
            at = at[key]
        if isinstance(at[key], int | float) and rng.random() < 0.6:
            at[key] *= 10.0 ** rng.randrange(-12, 12)
        elif rng.random() < 0.2:
            del at[key]
        else:
            at[key] = rng.choice((*VALUES, rng.uniform(-1, 1) * 10 ** rng.randrange(-40, 40)))
        return json.dumps(document).encode()
    except (ValueError, RecursionError, UnboundLocalError, TypeError, OverflowError):
        return _bytes(data, rng)


TEXT = (_bytes, _cell, _line, _column, _numbers, _numbers, _numbers)
MUTATORS = {
    "csv": TEXT,
    "rows": TEXT,
    "track.csv": TEXT,
    "csv.gz": (_bytes, _gzip, _gzip, _gzip),
    "zip": (_bytes, _zip, _zip, _zip),
    "parquet": (_bytes, _bytes, _frame),
    "noise.json": (_bytes, _key, _key, _key, _key),
}
"""Kind of input -> how to break it; all others byte by byte."""


def random_input(kind, rng):
    """Return a seed of a kind, broken."""
    return mutated(kind, rng.choice(fuzz_seeds.seeds(kind)), rng)


def generator(seed):
    """Return the generator that all of this is drawn from."""
    return random.Random(seed)
