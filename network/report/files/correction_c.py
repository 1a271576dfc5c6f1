"""The filter of a control as one C99 file: no library, no heap, nothing but constants, loops and two functions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from network.analysis.correction.correction import Correction
from network.analysis.correction.filter_model import FilterModel
from network.catalogue.declaration.declare import Array

HEAD = """/* Thermal correction of: {machine}
 *
 * Written by lptn. Plain C99: no library, no heap, no global state; a step takes {multiplications} multiplications.
 * {own} states of {full} and {unknown} for unknown heat, one step every {step} s.
{losses} *
 * lptn_start(state, inputs, sensors)        once: states from the first readings
 * lptn_step(state, inputs, sensors, moved)  every {step} s: corrects the states by the readings, tells how far the tool
 *                                           centre point has moved (tool minus workpiece), and goes on by a step
 *
 * inputs:  {inputs}
 * sensors: {sensors}
 * moved:   {axes}
 *
 * A sensor that is NaN is not read; without any the machine starts at {reference} degC. An input that is NaN counts as
 * at rest, a temperature as {reference} degC. What is `moved` is the displacement itself: the control takes it off.
 */
"""
TYPES = """
typedef struct { double z[LPTN_STATES]; } lptn_state;

void lptn_start(lptn_state *state, const double *inputs, const double *sensors);
void lptn_step(lptn_state *state, const double *inputs, const double *sensors, double *moved);

"""
ADD = """static void lptn_add(double *total, const double *column, double factor)
{
    int i;
    for (i = 0; i < LPTN_WIDTH; ++i) total[i] += column[i] * factor;
}

"""
LOOK_UP = """/* Straight between the rows of a table; beyond it along its last two. */
static void lptn_look_up(double *total, double value, double step, int rows, const double *zero, const double *above,
                         const double *below)
{
    const double *table = value > 0.0 ? above : below;
    double place = (value > 0.0 ? value : -value) / step;
    int i, k = place < (double)(rows - 2) ? (int)place : rows - 2;
    if (value == 0.0 || value != value) {
        lptn_add(total, zero, 1.0);
        return;
    }
    for (i = 0; i < LPTN_WIDTH; ++i) {
        double low = table[k * LPTN_WIDTH + i];
        total[i] += low + (place - (double)k) * (table[(k + 1) * LPTN_WIDTH + i] - low);
    }
}

"""
FILMS = """/* The heat of conductances that an input drives, beyond that at its mean. */
static void lptn_let_pass(double *driven, const lptn_state *state)
{
    int i, j, first = LPTN_STATES + LPTN_AXES + LPTN_SENSORS;
    for (j = 0; j < LPTN_FILMS; ++j) {
        double heat = driven[first + j];
        for (i = 0; i < LPTN_STATES; ++i) heat += lptn_film[j * LPTN_STATES + i] * state->z[i];
        heat *= driven[first + LPTN_FILMS + j];
        for (i = 0; i < LPTN_STATES + LPTN_AXES; ++i)
            driven[i] += heat * lptn_film_heat[j * (LPTN_STATES + LPTN_AXES) + i];
    }
}

"""
FUNCTIONS = """/* What the inputs do to the states in a step, to axes and sensors at once, and to conductances. */
static void lptn_drive(double *total, const double *inputs)
{
    int i;
    for (i = 0; i < LPTN_WIDTH; ++i) total[i] = lptn_constant[i];
@drive@    (void)inputs;
}

static void lptn_correct(lptn_state *state, const double *driven, const double *sensors, const double *gain)
{
    double missed[LPTN_SENSORS + 1];
    int i, j;
    for (j = 0; j < LPTN_SENSORS; ++j) {
        double expected = driven[LPTN_STATES + LPTN_AXES + j];
        for (i = 0; i < LPTN_STATES; ++i) expected += lptn_sensor[j * LPTN_STATES + i] * state->z[i];
        missed[j] = sensors[j] == sensors[j] ? sensors[j] - LPTN_REFERENCE - expected : 0.0;
    }
    for (i = 0; i < LPTN_STATES; ++i)
        for (j = 0; j < LPTN_SENSORS; ++j) state->z[i] += gain[i * LPTN_SENSORS + j] * missed[j];
}

void lptn_start(lptn_state *state, const double *inputs, const double *sensors)
{
    double driven[LPTN_WIDTH], sum = 0.0;
    int i, j, count = 0;
    for (j = 0; j < LPTN_SENSORS; ++j)
        if (sensors[j] == sensors[j]) {
            sum += sensors[j];
            ++count;
        }
    sum = count ? sum / count - LPTN_REFERENCE : 0.0;
    for (i = 0; i < LPTN_STATES; ++i) state->z[i] = lptn_uniform[i] * sum - lptn_offset[i];
    lptn_drive(driven, inputs);
    lptn_correct(state, driven, sensors, lptn_first_gain);
}

void lptn_step(lptn_state *state, const double *inputs, const double *sensors, double *moved)
{
    double driven[LPTN_WIDTH], next[LPTN_STATES];
    int i, j;
    lptn_drive(driven, inputs);
    lptn_correct(state, driven, sensors, lptn_gain);
@films@    for (i = 0; i < LPTN_AXES; ++i) {
        moved[i] = driven[LPTN_STATES + i];
        for (j = 0; j < LPTN_STATES; ++j) moved[i] += lptn_axis[i * LPTN_STATES + j] * state->z[j];
    }
    for (i = 0; i < LPTN_STATES; ++i) {
        next[i] = driven[i];
        for (j = 0; j < LPTN_STATES; ++j) next[i] += lptn_phi[i * LPTN_STATES + j] * state->z[j];
    }
    for (i = 0; i < LPTN_STATES; ++i) state->z[i] = next[i];
}
"""


def write_c(correction: Correction) -> str:
    """The file."""
    f = correction.filter
    helpers = ADD * bool(f.held or f.tables) + LOOK_UP * bool(f.tables)
    functions = FUNCTIONS.replace("@drive@", "".join(_drive_lines(f)))
    functions = functions.replace("@films@", "    lptn_let_pass(driven, state);\n" if len(f.films) else "")
    return "".join([_head(correction), *_constants(f), TYPES, helpers, FILMS * bool(len(f.films)), functions])


def _head(correction: Correction) -> str:
    f = correction.filter
    units = dict(zip(f.axes, f.axis_units, strict=True))
    losses = ""
    for loss in correction.losses:
        told = ", ".join(f"{axis} {1e6 * value:.3g} {units[axis]}" for axis, value in loss.by_axis.items())
        losses += f" * Lost against the full model along {_safe(loss.run)}: {told}.\n"
    return HEAD.format(
        machine=_safe(f.machine), multiplications=f.multiplications, own=f.own, full=correction.full,
        unknown=len(f.unknown),
        step=f"{f.step:g}", losses=losses, inputs=_list(f.inputs.items()),
        sensors=_list((name, "degC") for name in f.sensors), axes=_list(units.items()), reference=f"{f.reference:g}",
    )  # fmt: skip


def _list(named: Iterable[tuple[str, str]]) -> str:
    """Names with their places and units, one on a line."""
    return "\n *          ".join(f"[{i}] {_safe(name)} [{text}]" for i, (name, text) in enumerate(named)) or "none"


def _safe(text: str) -> str:
    """What may stand in a C comment: no begin, no end, no trigraph, one line."""
    return " ".join(text.split()).replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")


def _constants(f: FilterModel) -> Iterator[str]:
    sizes = {"STATES": f.states, "INPUTS": len(f.inputs), "SENSORS": len(f.sensors), "AXES": len(f.axes)}
    sizes |= {"FILMS": len(f.films)} if len(f.films) else {}
    named = ", ".join(f"LPTN_{name} = {size}" for name, size in (sizes | {"WIDTH": len(f.constant)}).items())
    yield f"enum {{ {named} }};\n#define LPTN_REFERENCE {f.reference!r}\n\n"
    arrays = {
        "constant": f.constant, "phi": f.Phi, "axis": f.M, "sensor": f.S, "gain": f.gain, "first_gain": f.first_gain,
        "uniform": f.uniform, "offset": f.offset,
    }  # fmt: skip
    arrays |= {"film": f.films, "film_heat": f.film_heat} if len(f.films) else {}
    for i, column in enumerate(f.held.values()):
        arrays[f"held_{i}"] = column
    for i, table in enumerate(f.tables):
        arrays |= {f"zero_{i}": table.zero, f"above_{i}": table.above, f"below_{i}": table.below}
    for name, values in arrays.items():
        yield _array(name, values)


def _array(name: str, values: Array) -> str:
    """A constant array; an empty one holds a zero, for C knows none of no length."""
    cells = [repr(float(value)) for value in np.ravel(values)] or ["0.0"]
    lines = [", ".join(cells[i : i + 6]) for i in range(0, len(cells), 6)]
    body = ",\n    ".join(lines)
    return f"static const double lptn_{name}[{len(cells)}] = {{\n    {body}}};\n"


def _drive_lines(f: FilterModel) -> Iterator[str]:
    order = list(f.inputs)
    for i, name in enumerate(f.held):
        k = order.index(name)
        yield f"    if (inputs[{k}] == inputs[{k}]) lptn_add(total, lptn_held_{i}, inputs[{k}] - LPTN_REFERENCE);\n"
    for i, table in enumerate(f.tables):
        rows = f"{table.step!r}, {len(table.above)}, lptn_zero_{i}, lptn_above_{i}, lptn_below_{i}"
        yield f"    lptn_look_up(total, inputs[{order.index(table.name)}], {rows});\n"
