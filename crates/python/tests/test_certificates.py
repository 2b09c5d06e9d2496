"""Certificates, checked here once more with Python's fractions."""

from fractions import Fraction
from typing import Any

import bracketry
import pytest

VAN_DER_POL = """
states = ["x", "y"]
dynamics = { x = "-y", y = "x + (x^2 - 1)*y" }
"""
Polynomial = dict[tuple[int, ...], Fraction]


def polynomial(terms: list[Any]) -> Polynomial:
    return {tuple(exponents): Fraction(c) for exponents, c in terms}


def product(a: Polynomial, b: Polynomial) -> Polynomial:
    out: Polynomial = {}
    for m, c in a.items():
        for k, d in b.items():
            key = tuple(i + j for i, j in zip(m, k))
            out[key] = out.get(key, Fraction(0)) + c * d
    return out


def added(*parts: Polynomial) -> Polynomial:
    out: Polynomial = {}
    for part in parts:
        for m, c in part.items():
            out[m] = out.get(m, Fraction(0)) + c
    return {m: c for m, c in out.items() if c != 0}


def scaled(p: Polynomial, c: Fraction) -> Polynomial:
    return {m: c * x for m, x in p.items()}


def derivative(p: Polynomial, i: int) -> Polynomial:
    lower = ((m[:i] + (m[i] - 1,) + m[i + 1 :], c * m[i]) for m, c in p.items() if m[i] > 0)
    return added(*({m: c} for m, c in lower))


def multiplied_out(gram: dict[str, Any]) -> Polynomial:
    rows = zip(gram["monomials"], gram["matrix"])
    return added(
        *({tuple(i + j for i, j in zip(a, b)): Fraction(q)} for a, row in rows for b, q in zip(gram["monomials"], row))
    )


def is_definite(gram: dict[str, Any]) -> bool:
    q = [[Fraction(x) for x in row] for row in gram["matrix"]]
    for k in range(len(q)):
        if q[k][k] <= 0:
            return False
        for i in range(k + 1, len(q)):
            factor = q[i][k] / q[k][k]
            q[i] = [x - factor * y for x, y in zip(q[i], q[k])]
    return True


def test_a_region_of_attraction_is_proved_by_its_certificate_alone() -> None:
    system = bracketry.System.from_toml(VAN_DER_POL)
    found = bracketry.certify(system, find="region", degree=2)
    assert found.proved and found.region is not None and found.region["conclusion"] == "region_of_attraction"
    certificate = found.region["certificate"]
    claim = certificate["claim"]
    v, level = polynomial(claim["function"]), Fraction(claim["level"])
    field = [polynomial(f) for f in certificate["field"]]
    assert field[0] == {(0, 1): Fraction(-1)}
    rate = added(*(product(derivative(v, i), f) for i, f in enumerate(field)))
    s = multiplied_out(claim["multiplier"])
    expected = added(scaled(rate, Fraction(-1)), scaled(s, -level), product(v, s))
    assert multiplied_out(claim["decrease"]) == expected and multiplied_out(claim["positive"]) == v
    assert is_definite(claim["decrease"]) and is_definite(claim["positive"]) and level > 2
    assert bracketry.check_certificate(system, certificate) == "region_of_attraction"
    claim["level"] = str(level + 1)
    assert bracketry.check_certificate(system, certificate) is None
    assert found.figure_names == ["region"] and found.figure("region").svg.startswith("<svg")


def test_feedback_and_mistakes() -> None:
    model = bracketry.System(states=["x"], inputs=["u"], dynamics=["x^3 + u"])
    found = bracketry.certify(model, feedback={"u": "-2*x - 2*x^3"}, find=["lyapunov", "conserved"])
    assert found.lyapunov is not None and found.lyapunov["conclusion"] == "globally_asymptotically_stable"
    assert found.conserved is not None and found.conserved["polynomials"] == []
    for arguments in ({"find": "nothing"}, {"degree": 3}, {"feedback": {"v": 0}}, {"at": {"z": 0}}, {"time_limit": 0}, {"time_limit": -1}):
        with pytest.raises(bracketry.BracketryError):
            bracketry.certify(model, **arguments)  # type: ignore[arg-type]
