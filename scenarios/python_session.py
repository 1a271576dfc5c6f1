"""A session in Python, cell by cell: simulate, compare, calibrate, find what is missing, plot, tabulate.

Open it in an editor that runs `# %%` cells, or run it: python scenarios/python_session.py
"""

# %% A machine and a schedule
from pathlib import Path

from network import Machine, Recording, Scenario, calibrate, choose_lumps, compare, diagnose, simulate, sweep
from network.report.files.result_files import write_run

HERE = Path(__file__).parent
machine = Machine.load(HERE.parent / "machines" / "gantry_spindle.yaml")
warm_up = Scenario.load(HERE / "warm_up_and_stop.yaml")
print(machine)  # everything in it, and what is uncertain; `machine` alone is one line

# %% What moves the tool, and where it comes from
run = simulate(machine, warm_up)
print(run)
z, hottest = run.shown("z"), run.shown("T_stator").max()  # µm and °C, as the names say
print(f"z ends at {z[-1]:.1f} µm; the stator reaches {hottest:.1f} °C")
axes = run.plot("z", "y")  # axes of matplotlib, to go on with
axes.set_title("A warm-up and a stop")

# %% Lumps: as many as it takes, part by part
chosen = choose_lumps(machine, warm_up)
print(chosen)
fine = simulate(chosen.machine, warm_up)
print(f"z reaches {fine.shown('z').max():.1f} µm instead of {z.max():.1f}")

# %% Other numbers: one, or a row of them
stiff = machine.patched({"links.flange.conductance": "60 W/K"})
same = Machine.load(machine.file, sets=["links.flange.conductance=60 W/K"])
print(f"{simulate(stiff, warm_up).shown('z')[-1] - simulate(same, warm_up).shown('z')[-1]:.1f} µm apart")
rows = sweep(machine, warm_up, vary=["links.flange.conductance=20..80 W/K:4"])
print(rows)

# %% A recording: here a simulation with a weaker coolant jacket and noise; yours is a CSV
out = Path("out/python_session")
out.mkdir(parents=True, exist_ok=True)
weaker = machine.patched({"links": {"coolant jacket": {"conductance": "20 W/K"}}})
for name, schedule in (("one", warm_up), ("two", Scenario.load(HERE / "day_of_work.yaml"))):
    (out / name).mkdir(exist_ok=True)
    write_run(simulate(weaker, schedule, noise_seed=1), out / name)
one, two = (Recording.load(out / name / "results.csv") for name in ("one", "two"))
beside = compare(machine, one)
print(beside)
beside.plot("dz")

# %% Calibrate on the one, look at the other
calibrated = calibrate(machine, one, two)
print(calibrated)
calibrated.plot("dz")

# %% Is something missing? Here nothing is: numbers were wrong
found = diagnose(machine, one, two, seconds=120)
print(found.verdict)

# %% Tables, for those who have pandas
try:
    print(run.to_pandas().describe())
    print(calibrated.to_pandas())
except ImportError as missing:
    print(missing)
