"""Numbers and comments as C: a compiler reads back every digit, and nobody's text becomes a program."""

import subprocess

import numpy as np
import pytest

from baroarma.export.c_text import Number, comment, real


def test_a_compiler_reads_back_every_digit(gcc, tmp_path):
    values = [
        0.1,
        -1 / 3,
        1e-300,
        2.0**24 + 1,
        16_777_215.0,
        0.0,
        -0.5,
        1e22,
        np.float64(np.pi),
        float("inf"),
    ]
    array = str(Number("VALUES", values, "to read back"))
    (tmp_path / "main.c").write_text(
        "#include <math.h>\n#include <stdio.h>\ntypedef double baroarma_real;\n"
        f"{array}\nint main(void) {{ int i; for (i = 0; i < {len(values)}; i++) "
        'printf("%.17g\\n", BAROARMA_VALUES[i]); return isnan(' + real(float("nan")) + ") ? 0 : 1; }"
    )
    done = subprocess.run([gcc(tmp_path, "main")], capture_output=True, text=True, check=True)
    assert [float(line) for line in done.stdout.split()] == values


@pytest.mark.parametrize("text", ["*/", "/*", "\\", "??/", "a\nb", "a\r\nb", "\x00", "é", "\u2028", "*\\\n/"])
def test_no_text_ends_a_comment_or_its_line(text):
    harmless = comment(text)
    assert "*" not in harmless
    assert "\\" not in harmless
    assert "?" not in harmless
    assert harmless.isascii()
    assert harmless.isprintable()


def test_whole_numbers_can_size_arrays():
    assert str(Number("STATES", 5, "of the filter")) == "#define BAROARMA_STATES 5 /* of the filter */"
    assert str(Number("MIDPOINT", True, "or not")).startswith("#define BAROARMA_MIDPOINT 1 ")


def test_a_compiler_that_knows_trigraphs_sees_a_comment_and_nothing_else(gcc, tmp_path):
    evil = ['*/ #error "out"', "??/", "\\", "// x", "/*", '"', "'", "\n#error line", "%s", "*\u200b/", "\x1a"]
    lines = "".join(f"/* {comment(text)} */\n" for text in [*evil, "".join(evil)])
    (tmp_path / "main.c").write_text(f"{lines}int main(void) {{ return 7; }}\n")
    assert subprocess.run([gcc(tmp_path, "main")]).returncode == 7
