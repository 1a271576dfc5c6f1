"""How long a step of the C file takes, by this machine's compiler."""

from __future__ import annotations

import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from network.report.files.c_compiler import compile_c

STEPS = 200_000
MAIN = """#include <stdio.h>
#include <time.h>
#include "{file}"
int main(void)
{{
    lptn_state state;
    double inputs[LPTN_INPUTS + 1], sensors[LPTN_SENSORS + 1], moved[LPTN_AXES + 1], sum = 0.0;
    clock_t began;
    int i;
    for (i = 0; i <= LPTN_INPUTS; ++i) inputs[i] = LPTN_REFERENCE;
    for (i = 0; i <= LPTN_SENSORS; ++i) sensors[i] = LPTN_REFERENCE;
    lptn_start(&state, inputs, sensors);
    began = clock();
    for (i = 0; i < {steps}; ++i) {{
        inputs[0] = LPTN_REFERENCE + (i & 15);
        lptn_step(&state, inputs, sensors, moved);
        sum += moved[0];
    }}
    printf("%g %g\\n", (double)(clock() - began) / CLOCKS_PER_SEC / {steps}, sum);
    return 0;
}}
"""


def time_step(c_file: Path) -> float | None:
    """Seconds a step of the file; None without a C compiler, or where it does not compile."""
    with TemporaryDirectory() as folder:
        main, program = Path(folder, "main.c"), Path(folder, "main")
        main.write_text(MAIN.format(file=c_file.resolve().as_posix(), steps=STEPS))
        if not compile_c(main, program):
            return None
        told = subprocess.run([str(program)], capture_output=True, text=True, check=False).stdout.split()
    return float(told[0]) if told else None
