"""SymPy expressions in the language of model files. SymPy is not imported: who passes its objects has done that."""

from __future__ import annotations

import functools
from typing import Any

from ._native import BracketryError

#: Functions with the names that model files know them by.
_FUNCTIONS = {
    name: name.lower()
    for name in "sin cos tan asin acos atan atan2 sinh cosh tanh exp log Abs sign Min Max".split()
}
#: Functions that are one over another.
_RECIPROCALS = {"sec": "cos", "csc": "sin", "cot": "tan", "sech": "cosh", "csch": "sinh", "coth": "tanh"}

#: How tightly a text holds together.
_SUM, _PRODUCT, _POWER, _ATOM = range(4)


def is_sympy(value: object) -> bool:
    """Whether a value is SymPy's."""
    return any(str(base.__module__).partition(".")[0] == "sympy" for base in type(value).__mro__)


def is_function_of_time(value: object) -> bool:
    """Whether a SymPy expression is an unknown function of one symbol, such as x(t)."""
    undefined = any(base.__name__ == "AppliedUndef" for base in type(value).__mro__)
    arguments: tuple[Any, ...] = getattr(value, "args", ())
    return undefined and len(arguments) == 1 and bool(getattr(arguments[0], "is_Symbol", False))


def sympy_text(value: Any, what: str) -> str:
    """A SymPy expression as text. x(t) becomes x, a time derivative of u(t) becomes der(u, order)."""
    return _Writer(what).written(value)[0]


class _Writer:
    def __init__(self, what: str) -> None:
        self.what = what

    def refuse(self, e: Any) -> BracketryError:
        known = ", ".join(sorted({*_FUNCTIONS.values(), "sqrt"}))
        kind = type(e).__name__
        return BracketryError(
            f"{self.what}: `{e}` ({kind}) cannot be used in a model; rewrite it with + - * / ^ and {known}"
        )

    def within(self, e: Any, level: int) -> str:
        """With parentheses where the text would fall apart among operators of that level."""
        text, own = self.written(e)
        return text if own >= level else f"({text})"

    def written(self, e: Any) -> tuple[str, int]:
        """The text with how tightly it holds together."""
        if e.is_Symbol:
            return str(e), _ATOM
        if e.is_Rational:
            if e.q != 1:
                return f"{e.p}/{e.q}", _SUM if e.p < 0 else _PRODUCT
            return str(e.p), _SUM if e.p < 0 else _ATOM
        if e.is_Float:
            text = repr(float(e))
            if "n" in text:
                raise self.refuse(e)
            return text, _SUM if text.startswith("-") else _ATOM
        kind = type(e).__name__
        if kind in ("Pi", "Exp1"):
            return {"Pi": "pi", "Exp1": "exp(1)"}[kind], _ATOM
        if e.is_Add:
            return self.sum(e.args), _SUM
        if e.is_Mul:
            return self.product(e.args)
        if e.is_Pow:
            return self.power(*e.args)
        if is_function_of_time(e):
            return kind, _ATOM
        if kind == "Derivative":
            return self.derivative(e), _ATOM
        if kind in _RECIPROCALS:
            return f"1/{_RECIPROCALS[kind]}({self.written(e.args[0])[0]})", _PRODUCT
        if kind in ("Max", "Min"):
            name, (first, *rest) = kind.lower(), [self.written(a)[0] for a in e.args]
            return functools.reduce(lambda one, other: f"{name}({one}, {other})", rest, first), _ATOM
        if kind in _FUNCTIONS:
            return f"{_FUNCTIONS[kind]}({', '.join(self.written(a)[0] for a in e.args)})", _ATOM
        raise self.refuse(e)

    def sum(self, terms: tuple[Any, ...]) -> str:
        text = ""
        for term in terms:
            written = f"({self.written(term)[0]})" if term.is_Add else self.written(term)[0]
            if written.startswith("-"):
                text += f" - {written[1:]}" if text else written
            else:
                text += f" + {written}" if text else written
        return text

    def product(self, factors: tuple[Any, ...]) -> tuple[str, int]:
        above, below, negative = [], [], False
        for f in factors:
            if f.is_Integer and f.p == -1:
                negative = not negative
            elif f.is_Pow and f.args[1].is_Rational and f.args[1].p < 0:
                below.append(self.power(f.args[0], -f.args[1]))
            else:
                above.append(self.within(f, _POWER) if f.is_Rational else self.within(f, _PRODUCT))
        text = "*".join(above) or "1"
        for factor, level in below:
            text += f"/{factor}" if level >= _POWER else f"/({factor})"
        return (f"-{text}", _SUM) if negative else (text, _PRODUCT)

    def power(self, base: Any, exponent: Any) -> tuple[str, int]:
        if exponent.is_Rational and exponent.p < 0:
            text, level = self.power(base, -exponent)
            return (f"1/{text}" if level >= _POWER else f"1/({text})"), _PRODUCT
        if exponent.is_Integer and exponent.p == 1:
            return self.written(base)
        if exponent.is_Rational and (exponent.p, exponent.q) == (1, 2):
            return f"sqrt({self.written(base)[0]})", _ATOM
        if type(base).__name__ == "Exp1":
            return f"exp({self.written(exponent)[0]})", _ATOM
        return f"{self.within(base, _ATOM)}^{self.within(exponent, _ATOM)}", _POWER

    def derivative(self, e: Any) -> str:
        of, *by = e.args
        if not is_function_of_time(of) or len(by) != 1 or by[0][0] != of.args[0]:
            raise self.refuse(e)
        return f"der({type(of).__name__}, {by[0][1]})"
