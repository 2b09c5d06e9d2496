//! LaTeX as it is written by hand.

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
        ("2/3 - x", r"-x + \frac{2}{3}"),
        ("-x - y", "-x - y"),
        ("x - 2*y", "x - 2 y"),
        ("-(-x)", "x"),
        ("x*y/(z*w)", r"\frac{x y}{z w}"),
        ("x/(y + z)*w", r"\frac{x w}{y + z}"),
        ("(x + y)/(x - y)", r"\frac{x + y}{x - y}"),
        ("x/y^2", r"\frac{x}{y^{2}}"),
        ("x^-2", r"\frac{1}{x^{2}}"),
        ("1/sqrt(x)", r"\frac{1}{\sqrt{x}}"),
        ("x^(3/2)", "x^{3/2}"),
        ("sqrt(sqrt(x) + 1)", r"\sqrt{\sqrt{x} + 1}"),
        ("(-2)^x", r"\left(-2\right)^{x}"),
        ("0.5^x", r"\left(0.5\right)^{x}"),
        ("x^(y + 1)", "x^{y + 1}"),
        ("(x^a)^b", r"\left(x^{a}\right)^{b}"),
        ("exp(-x^2/2)", r"\exp\left(-0.5 x^{2}\right)"),
        ("cos(2*theta_1)^2", r"\cos^{2}\left(2 \theta_{1}\right)"),
        ("1/cos(q)", r"\frac{1}{\cos\left(q\right)}"),
        ("tanh(x)^3*sinh(y)", r"\tanh^{3}\left(x\right) \sinh\left(y\right)"),
        ("asin(x)^2", r"\left(\arcsin\left(x\right)\right)^{2}"),
        ("abs(x - y)", r"\left|x - y\right|"),
        ("abs(x)/abs(y)", r"\frac{\left|x\right|}{\left|y\right|}"),
        ("min(x, 0)^2", r"\left(\min\left(x, 0\right)\right)^{2}"),
        ("m*g*l*sin(phi1 - phi2)", r"m g l \sin\left(\phi_{1} - \phi_{2}\right)"),
        ("Omega^2*I_zz", r"\Omega^{2} I_{\mathrm{zz}}"),
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
