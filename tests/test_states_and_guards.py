"""States and guards of entries: chillers, fans and valves against closed answers, other solvers and conservation."""

from __future__ import annotations

import numpy as np
import pytest
from catalogue import read_text

from network import registry
from network.calibration.calibrating import calibrate
from network.declare import Array
from network.diagnosis.candidates import kinds as searched
from network.fields import param, place
from network.inputs import Schedule, Signal, Start
from network.machine import Machine
from network.mechanisms.base import Inputs, Link, Relay, State, Stream, beyond
from network.mechanisms.switched_convection import SwitchedConvection
from network.recording import Recording
from network.refusal import Refused
from network.simulation import simulate
from network.trajectory import Trajectory
