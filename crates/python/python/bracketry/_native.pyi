from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TypeAlias, TypedDict, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "BracketryError",
    "CompensationStep",
    "Compensator",
    "Figures",
    "LiveController",
    "Model",
    "Page",
    "PlateController",
    "PlateStep",
    "Step",
    "__version__",
    "affinize",
    "analyze",
    "certify",
    "check_certificate",
    "choose_poses",
    "compensate",
    "control",
    "diagnose",
    "export",
    "from_rest",
    "from_rest_map",
    "identifiability",
    "identify",
    "linearize",
    "steer",
    "parameter_cases",
    "parameter_map",
    "run_command",
    "run_plate",
    "simulate",
    "transform",
    "trim",
    "weigh",
]

_Floats: TypeAlias = NDArray[np.float64]
_Bools: TypeAlias = NDArray[np.bool_]
_Path: TypeAlias = str | PathLike[str]
_Run: TypeAlias = str | tuple[str, Mapping[str, _Floats]]
_Text: TypeAlias = str | tuple[str, str]

__version__: str

class BracketryError(ValueError): ...

@final
class Figures:
    def names(self) -> list[str]: ...
    def svg(self, name: str) -> str: ...
    def png(self, name: str) -> bytes: ...

@final
class Page:
    def html(self) -> str: ...

@final
class CompensationStep:
    @property
    def reference(self) -> _Floats: ...
    @property
    def correction(self) -> _Floats: ...
    @property
    def wrench(self) -> _Floats: ...
    @property
    def displacement(self) -> _Floats: ...
    @property
    def fault(self) -> str | None: ...
    @property
    def limited(self) -> bool: ...

@final
class Compensator:
    def __new__(cls, robot: _Text, period: float | None) -> Compensator: ...
    def step(
        self, measured: Sequence[float] | _Floats, reading: Sequence[float], reference: Sequence[float] | _Floats
    ) -> CompensationStep: ...

@final
class PlateStep:
    @property
    def displacement_acceleration(self) -> float: ...
    @property
    def tilt_acceleration(self) -> float: ...
    @property
    def finished(self) -> bool: ...
    @property
    def status(self) -> str: ...
    @property
    def estimate(self) -> list[float] | None: ...
    @property
    def mu(self) -> float: ...
    @property
    def learned(self) -> dict[str, tuple[float, float]]: ...

@final
class PlateController:
    def __new__(
        cls,
        target: Sequence[float],
        numbers: Mapping[str, float | None],
        texts: Mapping[str, str | None],
        *,
        polygon: Sequence[Sequence[float]] | None,
        period: float,
        delay: int,
        mu_deviation: float,
        noise: Sequence[float],
        tolerance: Sequence[float],
    ) -> PlateController: ...
    def step(self, object: Sequence[float], plate: Sequence[float] | None) -> PlateStep: ...

@final
class Step:
    def __new__(
        cls,
        outcome: tuple[_Floats, str, str | None, str, int, int],
        figures: tuple[_Floats | None, _Floats | None, float | None, int, int, float, float],
    ) -> Step: ...
    def __getnewargs__(
        self,
    ) -> tuple[
        tuple[_Floats, str, str | None, str, int, int],
        tuple[_Floats | None, _Floats | None, float | None, int, int, float, float],
    ]: ...
    @property
    def u(self) -> _Floats: ...
    @property
    def status(self) -> str: ...
    @property
    def reason(self) -> str | None: ...
    @property
    def source(self) -> str: ...
    @property
    def sample(self) -> int: ...
    @property
    def missed(self) -> int: ...
    @property
    def estimate(self) -> _Floats | None: ...
    @property
    def innovation(self) -> _Floats | None: ...
    @property
    def residual(self) -> float | None: ...
    @property
    def programs(self) -> int: ...
    @property
    def iterations(self) -> int: ...
    @property
    def feedback_seconds(self) -> float: ...
    @property
    def prepare_seconds(self) -> float: ...

class _Prediction(TypedDict):
    t: _Floats
    states: _Floats
    inputs: _Floats

@final
class LiveController:
    def __new__(
        cls, *, path: _Path | None, text: str | None, folder: _Path, models: Mapping[str, Model], log: int
    ) -> LiveController: ...
    def step(self, y: Sequence[float] | _Floats, t: float | None) -> Step: ...
    def feedback(self, y: Sequence[float] | _Floats) -> Step: ...
    def lost(self) -> Step: ...
    def prepare(self) -> None: ...
    def reset(self, x0: Sequence[float] | _Floats | None) -> None: ...
    def set_reference(self, name: str, value: float) -> None: ...
    def set_reference_ahead(self, name: str, values: Sequence[float] | _Floats) -> None: ...
    def set_parameters(self, values: list[tuple[str, float]]) -> None: ...
    def set_bounds(self, name: str, min: float, max: float) -> None: ...
    def set_target(self, name: str, value: float) -> None: ...
    def predict(self) -> _Prediction: ...
    @property
    def predicted_cost(self) -> float: ...
    def slacks(self) -> dict[str, float]: ...
    def log(self) -> dict[str, _Floats] | None: ...
    def counts(self) -> str: ...
    @property
    def period(self) -> float: ...
    @property
    def delay(self) -> int: ...
    @property
    def measured(self) -> list[str]: ...
    @property
    def states(self) -> list[str]: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def references(self) -> list[str]: ...
    @property
    def parameters(self) -> list[str]: ...
    @property
    def targets(self) -> list[str]: ...

@final
class Model:
    @staticmethod
    def parse(file: str, text: str, name: str) -> Model: ...
    @staticmethod
    def read(path: _Path) -> Model: ...
    @property
    def file(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def states(self) -> list[str]: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def input_derivatives(self) -> list[tuple[str, int]]: ...
    @property
    def parameters(self) -> list[tuple[str, float, str | None, float | None, float | None, str | None]]: ...
    @property
    def point(self) -> tuple[list[float], list[float]] | None: ...
    @property
    def time_unit(self) -> str: ...
    @property
    def units(self) -> dict[str, str]: ...
    @property
    def titles(self) -> dict[str, str]: ...
    def with_parameters(self, values: Sequence[tuple[str, str]]) -> Model: ...
    def to_toml(self) -> str: ...
    def equations(self) -> list[tuple[str, str]]: ...
    def latex(self) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]: ...
    def rates(self, rows: _Floats) -> _Floats: ...
    def output_values(self, rows: _Floats) -> _Floats: ...
    def jacobian(self, rows: _Floats) -> _Floats: ...

class _Answer(TypedDict):
    json: str
    text: str
    figures: Figures

class _Analysis(_Answer):
    markdown: str
    latex: str
    affine_model: Model | None

class _Affinization(TypedDict):
    json: str
    changes: list[str]
    model: Model

class _Simulation(_Answer):
    t: _Floats
    states: _Floats
    inputs: _Floats
    outputs: _Floats

class _Control(_Answer):
    t: _Floats
    states: _Floats
    inputs: _Floats
    measured: _Floats
    estimates: _Floats
    state_names: list[str]
    input_names: list[str]
    titles: dict[str, str]

class _Diagnosis(_Answer):
    page: Page
    extended_model: Model | None

class _Identification(_Answer):
    identified_robot: str | None

class _Compensation(_Answer):
    t: _Floats
    corrected: _Floats
    correction: _Floats
    wrench: _Floats
    displacement: _Floats
    held: _Bools
    limited: _Bools

class _Trim(_Answer):
    model: Model

class _Transformation(_Answer):
    model: Model | None
    parts: list[tuple[str, Model]]

class _Linearization(_Answer):
    files: list[tuple[str, str]]

class _Export(_Answer):
    source: str

class _Steering(_Answer):
    trajectory: tuple[list[str], list[list[float]]] | None
    scenario: str | None
    model: Model

class _ChosenPoses(_Answer):
    rows: _Floats
    identifies_all: bool

class _Weighing(_Answer):
    toml: str

class _PlateRun(_Answer):
    t: _Floats
    states: _Floats
    plate_displacement: _Floats
    plate_tilt: _Floats
    amplitude: _Floats
    normal_force: _Floats
    stick_fraction: _Floats
    gap: _Floats
    lean: _Floats

def analyze(model: Model, at: str | None, brackets: Sequence[str], determines: Sequence[str]) -> _Analysis: ...
def affinize(model: Model) -> _Affinization: ...
def certify(
    model: Model, at: str | None, feedback: Sequence[str], find: Sequence[str], degree: int, time_limit: float
) -> _Answer: ...
def check_certificate(
    model: Model, at: str | None, feedback: Sequence[str], certificate: str
) -> tuple[str | None, str]: ...
def trim(
    model: Model, asked: tuple[list[tuple[str, str]], list[str], list[str], int, int]
) -> _Trim: ...
def parameter_cases(model: Model, parameters: list[str], conditions: int) -> _Answer: ...
def parameter_map(model: Model, ranges: str, cells: int, conditions: int) -> _Answer: ...
def identifiability(
    model: Model, known_initial: list[str], unknown_inputs: list[str], global_: bool
) -> _Answer: ...
def from_rest(model: Model, bounds: str, at: str | None, time_limit: float) -> _Answer: ...
def from_rest_map(
    model: Model, axes: str, bounds: str, at: str | None, cells: int, time_limit: float
) -> _Answer: ...
def linearize(model: Model, at: str | None, weights: list[list[float]], horizon: float | None) -> _Linearization: ...
def transform(model: Model, to: str, at: str | None, outputs: Sequence[str], time_limit: float) -> _Transformation: ...
def export(model: Model, language: str, parameters: Sequence[str], name: str | None) -> _Export: ...
def steer(
    model: Model,
    asked: tuple[str | None, str, str],
    duration: float | None,
    method: str,
    time_limit: float,
    seed: int,
) -> _Steering: ...
def simulate(
    model: Model,
    *,
    text: str | None,
    file: _Path | None,
    table: _Path | None,
    samples: Mapping[str, tuple[_Floats, _Floats]],
    hold_inputs: str,
    start: float,
    duration: float | None,
    sample: float | None,
    rtol: float | None,
    atol: float | None,
    ignored: Sequence[str],
) -> _Simulation: ...
def control(
    *,
    path: _Path | None,
    text: str | None,
    folder: _Path,
    models: Mapping[str, Model],
    seed: int | None,
) -> _Control: ...
def diagnose(
    model: Model,
    data: Sequence[_Run],
    validate: Sequence[_Run],
    *,
    hold_inputs: str | None,
    rename: Sequence[tuple[str, str]],
    fix: Sequence[str],
    reference: Model | None,
    max_causes: int | None,
    seed: int | None,
    window: float | None,
    horizon: Sequence[float],
    time_limit: float,
    threads: int,
) -> _Diagnosis: ...
def identify(data: _Text, robot: _Text, keep_outliers: bool) -> _Identification: ...
def compensate(log: _Text, robot: _Text, process_stiffness: Sequence[float] | None) -> _Compensation: ...
def choose_poses(candidates: _Text, robot: _Text, count: int) -> _ChosenPoses: ...
def weigh(readings: _Text, robot: _Text) -> _Weighing: ...
def run_command(arguments: Sequence[str]) -> int: ...
def run_plate(
    numbers: Mapping[str, float | None],
    texts: Mapping[str, str | None],
    *,
    scenario: _Path | None,
    polygon: Sequence[Sequence[float]] | None,
    log: _Text | None,
    driven_by_log: bool,
) -> _PlateRun: ...
