PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test test-matrix proofs speed torture bench pairs clean

demo: .venv/ready
	$(BIN)/lptn demo

test: .venv/ready-to-test
	$(BIN)/ruff check network tests
	$(BIN)/mypy
	$(BIN)/pytest -n 2

proofs: .venv/ready-to-test
	$(BIN)/pytest -n 2 -m proof

speed: .venv/ready-to-test
	$(BIN)/pytest -m speed

test-matrix:
	$(PYTHON) tests/matrix.py

torture: .venv/ready-to-test
	-cd tests && ../$(BIN)/python -m torture --folder ../.torture $(TORTURE)
	-cd tests && ../$(BIN)/python -m torture.stops --log ../.torture/stops.jsonl
	-cd tests && ../$(BIN)/python -m torture.faults --log ../.torture/faults.jsonl
	-cd tests && ../$(BIN)/python -m torture.agreement --log ../.torture/agreement.jsonl
	cd tests && ../$(BIN)/python -m torture.told --folder ../.torture

bench: .venv/ready-to-test
	cd tests && ../$(BIN)/python -m bench

pairs: .venv/ready-to-test
	cd tests && ../$(BIN)/python -m bench.then_and_now --seed 1011 $(PAIRS)

.venv/ready: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install -q --disable-pip-version-check -e .
	@touch $@

.venv/ready-to-test: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[test]'
	@touch .venv/ready $@

clean:
	rm -rf .venv out build *.egg-info
