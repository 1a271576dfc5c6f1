"""The FMU: run by fmpy beside Python, valid by the standard's schema, whole without a compiler too."""

from __future__ import annotations

import json
import platform
import re
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from network import Machine, Scenario, simulate
from network.analysis.correction.correction import Correction, make_correction, sample_inputs
from network.catalogue.declaration.declare import Array
from network.cli import main
from network.report.files import c_compiler
from network.report.files.fmu import write_fmu

ROOT = Path(__file__).parents[1]
GANTRY = ROOT / "machines" / "gantry_spindle.yaml"
WARM_UP = ROOT / "scenarios" / "warm_up_and_stop.yaml"
try:
    import fmpy
    import fmpy.validation
except ImportError:
    fmpy = None
with_gcc = pytest.mark.skipif(c_compiler.find_compiler() is None, reason="no C compiler")
with_fmpy = pytest.mark.skipif(fmpy is None, reason="fmpy is not installed: pip install 'lptn[test]'")


def correction(name: str = "gantry_spindle", run: str = "warm_up_and_stop", **more: Any) -> Correction:
    machine = Machine.load(ROOT / "machines" / f"{name}.yaml")
    return make_correction(machine, [Scenario.load(ROOT / "scenarios" / f"{run}.yaml")], **more)


def table(t: Array, columns: dict[str, Array]) -> Array:
    """A structured array as fmpy takes and gives it: time, then columns by name."""
    out = np.zeros(len(t), dtype=[(name, float) for name in ("time", *columns)])
    for name, values in {"time": t, **columns}.items():
        out[name] = values
    return out


def step_by_step(of: Correction, inputs: dict[str, Array], read: Array) -> dict[str, Array]:
    """What the FMU is to say at t[1:], by the filter in Python: axes, then temperatures at the sensors."""
    f = of.filter
    rows = [dict(zip(inputs, row, strict=True)) for row in np.stack([*inputs.values()], axis=1).tolist()]
    z, told = f.start(rows[0], read[0]), []
    for row, readings in zip(rows[:-1], read[:-1], strict=True):
        z = f.advance(z, row, readings)[0]
        first = f.states + len(f.axes)
        at_sensors = f.S @ z + f.driven(row)[first : first + len(f.sensors)] + f.reference
        told.append([*f.tell(z, row), *at_sensors])
    return dict(zip([*(f"tcp.{axis}" for axis in f.axes), *f.sensors], np.array(told).T, strict=True))


def run(path: Path, t: Array, given: dict[str, Array], **more: Any) -> Any:
    stop = float(t[-1])
    return fmpy.simulate_fmu(str(path), input=table(t, given), stop_time=stop, output_interval=t[1] - t[0], **more)


@with_fmpy
@with_gcc
@pytest.mark.parametrize(
    ("name", "scenario"),
    [("gantry_spindle", "warm_up_and_stop"), ("vertical_mill", "day_of_work"), ("cnc_lathe", "shop_day")],
)
def test_fmpy_gets_what_python_says(name: str, scenario: str, tmp_path: Path) -> None:
    """To 1e-6 K and µm, readings that come and fail, and without any; never further off the machine than was told."""
    of, rng = correction(name, scenario, states=None if name != "cnc_lathe" else 9), np.random.default_rng(3)
    f, machine = of.filter, of.machine
    write_fmu(of, tmp_path / "correction.fmu")
    truth = simulate(machine, Scenario.load(ROOT / "scenarios" / f"{scenario}.yaml"))
    t, inputs = sample_inputs(f, truth.schedule)
    t = t - t[0]
    read = np.stack([np.interp(t, truth.t, truth.sensors[n]) for n in f.sensors], axis=1)
    read += 0.5 * rng.standard_normal(read.shape)
    read[rng.random(read.shape) < 0.2] = np.nan
    for readings in (read, np.full_like(read, np.nan)):
        given = {f"read.{n}": np.nan_to_num(readings[:, i], nan=-273.15) for i, n in enumerate(f.sensors)}
        expected = step_by_step(of, inputs, readings)
        told = run(tmp_path / "correction.fmu", t, inputs | given)
        for each, values in expected.items():
            np.testing.assert_allclose(told[each][1:], values, rtol=0, atol=1e-6)
            assert np.ptp(values) > 0.1


@with_fmpy
@with_gcc
def test_the_fmu_follows_the_full_model(tmp_path: Path) -> None:
    """From the reference temperature, no sensor read: the largest difference is what the export tells, and what a step
    of 10 s later an input makes."""
    of = correction()
    write_fmu(of, tmp_path / "correction.fmu")
    hour = Scenario.of("hour", "1 h", {"speed": "6000 rpm", "ambient": "21.6 degC"}, output="10 s", start="21.6 degC")
    truth = simulate(of.machine, hour)
    t, inputs = sample_inputs(of.filter, truth.schedule)
    told = run(tmp_path / "correction.fmu", t, inputs)
    for axis in of.filter.axes:
        assert np.abs(told[f"tcp.{axis}"] - 1e6 * np.interp(t, truth.t, truth.tcp[axis])).max() < 0.3
    for name in of.filter.sensors:
        assert np.abs(told[name] - np.interp(t, truth.t, truth.sensors[name])).max() < 0.3


@with_fmpy
@with_gcc
def test_the_standard_finds_no_fault(tmp_path: Path) -> None:
    write_fmu(correction(), tmp_path / "correction.fmu")
    assert fmpy.validation.validate_fmu(str(tmp_path / "correction.fmu")) == []
    description = fmpy.read_model_description(str(tmp_path / "correction.fmu"), validate=True)
    assert {v.unit for v in description.modelVariables} == {"degC", "rpm", "um"}
    assert description.coSimulation.modelIdentifier == "correction"


@with_fmpy
@with_gcc
def test_a_state_can_be_kept_and_taken_up_again(tmp_path: Path) -> None:
    from fmpy.fmi2 import FMU2Slave

    write_fmu(correction(), tmp_path / "correction.fmu")
    description = fmpy.read_model_description(str(tmp_path / "correction.fmu"))
    folder = fmpy.extract(str(tmp_path / "correction.fmu"), str(tmp_path))
    unit = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier="correction", instanceName="one")
    unit.instantiate()
    unit.setupExperiment(startTime=100.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    speed, z = (next(v.valueReference for v in description.modelVariables if v.name == n) for n in ("speed", "tcp.z"))
    unit.setReal([speed], [8000.0])

    def go(begin: float, step: float, count: int) -> float:
        for k in range(count):
            unit.doStep(begin + k * step, step)
        return float(unit.getReal([z])[0])

    go(100, 10, 30)
    kept = unit.getFMUstate()
    bytes_ = unit.serializeFMUstate(kept)
    on = go(400, 10, 60)
    unit.setFMUstate(unit.deSerializeFMUstate(bytes_))
    assert go(400, 2.5, 240) == on != 0.0, "steps of any length give the same"
    unit.reset()
    assert unit.getReal([speed]) == [0.0]
    with pytest.raises(Exception, match="status 3"):
        unit.setReal([z], [1.0])
    unit.terminate()
    unit.freeInstance()


@with_gcc
def test_the_sources_build_alone_with_names_of_their_own(tmp_path: Path) -> None:
    write_fmu(correction(), tmp_path / "correction.fmu")
    zipfile.ZipFile(tmp_path / "correction.fmu").extractall(tmp_path)
    flags = [*c_compiler.FLAGS, "-Wshadow", "-Wmissing-prototypes", "-c", "fmu.c", "-o", "fmu.o"]
    subprocess.run([str(c_compiler.find_compiler()), *flags], cwd=tmp_path / "sources", check=True)
    names = subprocess.run(["nm", "fmu.o"], cwd=tmp_path / "sources", capture_output=True, text=True, check=True).stdout
    assert "T correction_fmi2DoStep" in names and not re.search(r" T fmi2", names)


def test_without_a_compiler_it_holds_sources_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(c_compiler, "find_compiler", lambda: None)
    main(["export", str(GANTRY), str(WARM_UP), "--as", "fmu", "-o", str(tmp_path)])
    assert "holds sources alone, for no C compiler" in capsys.readouterr().out
    names = zipfile.ZipFile(tmp_path / "correction.fmu").namelist()
    assert sorted(names) == ["modelDescription.xml", "sources/correction.c", "sources/fmu.c"]
    assert json.loads((tmp_path / "export.json").read_text())["binaries"] == []


def test_names_that_xml_knows_otherwise_are_kept(tmp_path: Path) -> None:
    from xml.etree import ElementTree as ET

    text = GANTRY.read_text(encoding="utf-8").replace("T_nose", '"T <&> nose"')
    (tmp_path / "machine.yaml").write_text(text, encoding="utf-8")
    write_fmu(make_correction(Machine.load(tmp_path / "machine.yaml"), []), tmp_path / "correction.fmu")
    root = ET.fromstring(zipfile.ZipFile(tmp_path / "correction.fmu").read("modelDescription.xml"))
    assert "T <&> nose" in {variable.get("name") for variable in root.iter("ScalarVariable")}


@with_gcc
def test_the_same_machine_makes_the_same_sources(tmp_path: Path) -> None:
    of = correction()
    for name in "ab":
        write_fmu(of, tmp_path / name)
    a, b = ({n: z.read(n) for n in z.namelist() if not n.startswith("binaries")}
            for z in (zipfile.ZipFile(tmp_path / name) for name in "ab"))  # fmt: skip
    assert a == b and len(a) == 3


@with_gcc
@pytest.mark.skipif(platform.system() != "Linux" or platform.machine() != "x86_64", reason="another platform")
def test_the_readme_shows_what_comes_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    blocks = (ROOT / "README.md").read_text(encoding="utf-8").split("```")
    at = next(i for i, block in enumerate(blocks) if "--as fmu" in block and block.startswith("\nlptn"))
    main(["export", str(GANTRY), str(WARM_UP), "--as", "fmu", "-o", str(tmp_path)])
    assert blocks[at + 2].strip() in capsys.readouterr().out
