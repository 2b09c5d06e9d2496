"""What can my inputs reach, how do I get there, and where are the equations wrong?

A model is a :class:`System`. :func:`analyze` says what its inputs reach, :func:`affinize` makes it affine in them,
:func:`trim` finds operating points, :func:`linearize` gives the linear system there, :func:`transform` its normal forms,
:func:`parameter_cases` for which values of parameters that changes, :func:`identifiability` which parameters can be known,
:func:`steer` moves it from one state to another, :func:`simulate` integrates it with exact dry friction, :func:`control` closes a
loop, :class:`Controller` is stepped on a plant of your own, :func:`diagnose` names what it gets wrong
in measured data. :mod:`bracketry.plate` is for the vibrating plate, :mod:`bracketry.stiffness` for robots that bend,
:func:`sweep` for many runs at once. :func:`certify` proves stability and passivity of polynomial models. :meth:`System.export`
writes the equations as source code.
"""

from . import plate, stiffness
from ._analysis import Affinization, Analysis, AtPoint, LocalControllability, Mode, Reach, affinize, analyze
from ._certificates import Certification, certify, check_certificate
from ._control import ClosedLoop, control
from ._controller import Controller, Prediction
from ._diagnosis import Candidate, Cause, Diagnosis, Estimate, Gain, Place, RefittedParameter, Rival, Windows, diagnose
from ._export import Export
from ._forms import Transformation, transform
from ._from_rest import FromRest, FromRestMap, from_rest, from_rest_map
from ._linear import Gain as LinearGain
from ._linear import Linearization, Trim, linearize, trim
from ._native import BracketryError, Step, __version__
from ._parameters import Identifiability, ParameterCases, ParameterMap, identifiability, parameter_cases, parameter_map
from ._result import Figure, Result
from ._sampled import Sampled
from ._simulation import Event, Trajectory, simulate
from ._steering import Steering, steer
from ._sweep import sweep
from ._system import Parameter, System

__all__ = [
    "Affinization",
    "Analysis",
    "AtPoint",
    "BracketryError",
    "Candidate",
    "Cause",
    "Certification",
    "ClosedLoop",
    "Controller",
    "Diagnosis",
    "Estimate",
    "Event",
    "Export",
    "Figure",
    "FromRest",
    "FromRestMap",
    "Gain",
    "Identifiability",
    "LinearGain",
    "Linearization",
    "LocalControllability",
    "Mode",
    "Parameter",
    "ParameterCases",
    "ParameterMap",
    "Place",
    "Prediction",
    "Reach",
    "RefittedParameter",
    "Result",
    "Rival",
    "Sampled",
    "Steering",
    "Step",
    "System",
    "Trajectory",
    "Transformation",
    "Trim",
    "Windows",
    "__version__",
    "affinize",
    "analyze",
    "certify",
    "check_certificate",
    "control",
    "diagnose",
    "from_rest",
    "from_rest_map",
    "identifiability",
    "linearize",
    "parameter_cases",
    "parameter_map",
    "plate",
    "simulate",
    "steer",
    "stiffness",
    "sweep",
    "transform",
    "trim",
]
