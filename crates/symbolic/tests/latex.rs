//! LaTeX as it is written by hand.
#![allow(clippy::unwrap_used)]

use bracketry_symbolic::Pool;

#[test]
fn expressions_in_latex() {
    for (text, latex) in [
        ("mu*g", r"\mu g"),
        ("theta_1 + theta2", r"\theta_{1} + \theta_{2}"),
        ("x_10", "x_{10}"),
        ("F_x_max", r"F_{x,\mathrm{max}}"),
        ("v_theta", r"v_{\theta}"),
        ("xd + thetadd", r"\mathrm{xd} + \mathrm{thetadd}"),
        ("x/y", r"\frac{x}{y}"),
        ("2*x/(3*y)", r"\frac{2 x}{3 y}"),
        ("-x/2", "-0.5 x"),
        ("x/3", r"\frac{x}{3}"),
        ("-1/3", r"-\frac{1}{3}"),
        ("x^2*y", "x^{2} y"),
        ("(x + y)^2", r"\left(x + y\right)^{2}"),
        ("x*(y - z)", r"x \left(y - z\right)"),
        ("z - (x + y)", r"z - \left(x + y\right)"),
        ("-(x + y)/z", r"-\frac{x + y}{z}"),
        ("1/(x + y)", r"\frac{1}{x + y}"),
        ("1/((x + y)*z)", r"\frac{1}{\left(x + y\right) z}"),
        ("sqrt(x + 1)", r"\sqrt{x + 1}"),
        ("x^(2/3)", "x^{2/3}"),
        ("x^(-a)", "x^{-a}"),
        ("(x*y)^a", r"\left(x y\right)^{a}"),
        ("2*3^x", r"2 \cdot 3^{x}"),
        ("sin(theta)^2", r"\sin^{2}\left(\theta\right)"),
        ("exp(x)^a", r"\left(\exp\left(x\right)\right)^{a}"),
        ("sign(v)*abs(v)^2", r"\operatorname{sgn}\left(v\right) \left|v\right|^{2}"),
        ("atan2(y, x) - max(x, y)", r"\operatorname{atan2}\left(y, x\right) - \max\left(x, y\right)"),
        ("pi*x - 3", r"\pi x - 3"),
        ("atan(x) - log(x)", r"\arctan\left(x\right) - \ln\left(x\right)"),
    ] {
        let mut p = Pool::new();
        let e = p.parse(text).unwrap();
        assert_eq!(p.latex(e), latex, "{text}");
    }
}

#[test]
fn names_are_escaped() {
    let mut p = Pool::new();
    for (name, latex) in [("a%b", r"\mathrm{a\%b}"), ("_", r"\mathrm{\_}"), ("θ", "θ"), ("7", "7")] {
        let e = p.var(name);
        assert_eq!(p.latex(e), latex);
    }
}
