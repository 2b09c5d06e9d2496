"""Reads Julia of the form that is exported, as Python: only what differs between the two is translated."""

import keyword
import math
import re


def nan_at_errors(f):
    def safe(*a):
        try:
            return f(*a)
        except (ValueError, OverflowError):
            return math.nan

    return safe


BASE = {n: nan_at_errors(getattr(math, n)) for n in "sin cos tan asin acos sinh cosh tanh exp log sqrt".split()}
BASE |= {
    "__builtins__": {},
    "abs": math.fabs,
    "atan": lambda *a: math.atan(*a) if len(a) == 1 else math.atan2(*a),
    "max": max,
    "min": min,
    "reshape": lambda v, n, m: [v[j * n + i] for i in range(n) for j in range(m)] if len(v) == n * m else None,
    "sign": lambda a: (a > 0.0) - (a < 0.0),
    "zeros": lambda n, m: [],
}


def module(text, name):
    """The functions of a module by name; matrices are given back row by row."""
    lines, depth = [], 0
    for line in text.splitlines():
        if not line or line.startswith(("#", "const STATES", "const INPUTS", "const OUTPUTS", "const PARAMETERS")):
            continue
        word = line.split()[0]
        depth += (word in ("module", "function")) - (word == "end")
        assert depth <= 2 and (word != "module" or line.split()[1] == name), line
        if word in ("module", "end"):
            continue
        # Names that only Python reserves.
        line = re.sub(r"\w+", lambda m: m[0] + "_py" * (keyword.iskeyword(m[0]) and m[0] != "return"), line)
        if word == "function":
            line = "def " + line.removeprefix("function ").replace("Float64[]", "()") + ":"
        line = re.sub(r"\b([xup])\[(\d+)\]", lambda m: f"{m[1]}[{int(m[2]) - 1}]", line).replace(" ^ ", " ** ")
        lines.append(line.removeprefix("const "))
    assert depth == 0
    scope = dict(BASE)
    exec("\n".join(lines), scope)
    return scope


