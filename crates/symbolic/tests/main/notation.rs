//! Formulas: composed by hand, and set in MathML.

use crate::common::{Kind, cases, generator, random};
use bracketry_symbolic::{Fence, Joint, Notation, Pool, Relation};
use proptest::prelude::*;

/// Without the element around it.
fn set(formula: &Notation) -> String {
    let text = formula.mathml();
    text.strip_prefix("<math>").and_then(|t| t.strip_suffix("</math>")).unwrap().to_owned()
}

fn parsed(text: &str) -> Notation {
    let mut p = Pool::new();
    let e = p.parse(text).unwrap();
    p.notation(e)
}

#[test]
fn expressions_in_mathml() {
    let upright = |name: &str| format!("<mi mathvariant=\"normal\">{name}</mi>");
    let argument = |inside: &str| format!("<mrow><mo>(</mo><mrow>{inside}</mrow><mo>)</mo></mrow>");
    for (text, expected) in [
        ("x + y", "<mrow><mi>x</mi><mo>+</mo><mi>y</mi></mrow>".to_owned()),
        ("x - 2*y", "<mrow><mi>x</mi><mo>−</mo><mrow><mn>2</mn><mi>y</mi></mrow></mrow>".to_owned()),
        ("-x", "<mrow><mo>−</mo><mi>x</mi></mrow>".to_owned()),
        ("x*y", "<mrow><mi>x</mi><mi>y</mi></mrow>".to_owned()),
        ("2*3^x", "<mrow><mn>2</mn><mo>·</mo><msup><mn>3</mn><mi>x</mi></msup></mrow>".to_owned()),
        ("x/y", "<mfrac><mi>x</mi><mi>y</mi></mfrac>".to_owned()),
        ("1/3", "<mfrac><mn>1</mn><mn>3</mn></mfrac>".to_owned()),
        ("0.5", "<mn>0.5</mn>".to_owned()),
        ("pi", "<mi>π</mi>".to_owned()),
        ("sqrt(x)", "<msqrt><mi>x</mi></msqrt>".to_owned()),
        ("x^(2/3)", "<msup><mi>x</mi><mrow><mn>2</mn><mo>/</mo><mn>3</mn></mrow></msup>".to_owned()),
        ("x^y^z", "<msup><mi>x</mi><msup><mi>y</mi><mi>z</mi></msup></msup>".to_owned()),
        (
            "(x^y)^z",
            "<msup><mrow><mo>(</mo><msup><mi>x</mi><mi>y</mi></msup><mo>)</mo></mrow><mi>z</mi></msup>".to_owned(),
        ),
        (
            "x*(y - z)",
            "<mrow><mi>x</mi><mrow><mo>(</mo><mrow><mi>y</mi><mo>−</mo><mi>z</mi></mrow><mo>)</mo></mrow></mrow>"
                .to_owned(),
        ),
        ("theta_1", "<msub><mi>θ</mi><mrow><mn>1</mn></mrow></msub>".to_owned()),
        ("theta1^2", "<msubsup><mi>θ</mi><mrow><mn>1</mn></mrow><mn>2</mn></msubsup>".to_owned()),
        ("F_x_max", format!("<msub><mi>F</mi><mrow><mi>x</mi><mo>,</mo>{}</mrow></msub>", upright("max"))),
        ("Omega*mass", format!("<mrow><mi>Ω</mi>{}</mrow>", upright("mass"))),
        ("abs(v)", "<mrow><mo>|</mo><mi>v</mi><mo>|</mo></mrow>".to_owned()),
        ("sign(v)", format!("<mrow>{}{}</mrow>", upright("sgn"), argument("<mi>v</mi>"))),
        ("sin(x)^2", format!("<mrow><msup>{}<mn>2</mn></msup>{}</mrow>", upright("sin"), argument("<mi>x</mi>"))),
        ("min(x, 2)", format!("<mrow>{}{}</mrow>", upright("min"), argument("<mi>x</mi><mo>,</mo><mn>2</mn>"))),
    ] {
        assert_eq!(set(&parsed(text)), expected, "{text}");
    }
}

#[test]
fn every_function_has_a_name_in_both() {
    for (text, name) in [
        ("sin(x)", "sin"),
        ("cos(x)", "cos"),
        ("tan(x)", "tan"),
        ("asin(x)", "arcsin"),
        ("acos(x)", "arccos"),
        ("atan(x)", "arctan"),
        ("sinh(x)", "sinh"),
        ("cosh(x)", "cosh"),
        ("tanh(x)", "tanh"),
        ("exp(x)", "exp"),
        ("log(x)", "ln"),
        ("sign(x)", "sgn"),
        ("atan2(x, y)", "atan2"),
        ("min(x, y)", "min"),
        ("max(x, y)", "max"),
    ] {
        let formula = parsed(text);
        assert!(formula.mathml().contains(&format!(">{name}</mi>")), "{text}: {}", formula.mathml());
        assert!(formula.latex().contains(name), "{text}: {}", formula.latex());
    }
}

#[test]
fn time_derivatives_have_dots() {
    for (order, latex, mathml) in [
        (1, r"\dot{\theta}", "<mi style=\"font-style:italic\">θ\u{307}</mi>"),
        (2, r"\ddot{\theta}", "<mi style=\"font-style:italic\">θ\u{308}</mi>"),
    ] {
        let formula = Notation::symbol("theta").dotted(order);
        assert_eq!((formula.latex().as_str(), set(&formula).as_str()), (latex, mathml));
        assert_eq!(set(&Notation::symbol(format!("der(theta, {order})"))), mathml);
    }
    let third = Notation::symbol("theta").dotted(3);
    assert_eq!(third.latex(), r"{\theta}^{(3)}");
    assert_eq!(third.superscript(Notation::number(2)).latex(), r"{{\theta}^{(3)}}^{2}");
    assert_eq!(
        set(&Notation::symbol("load").dotted(1)),
        "<mover accent=\"true\"><mi mathvariant=\"normal\">load</mi><mo>˙</mo></mover>"
    );
    // On the letter, not on its index.
    assert_eq!(
        set(&Notation::symbol("q1").dotted(1)),
        "<msub><mi style=\"font-style:italic\">q\u{307}</mi><mrow><mn>1</mn></mrow></msub>"
    );
}

#[test]
fn derivatives_of_inputs_can_be_dotted_in_an_expression() {
    let mut p = Pool::new();
    let (u, rate) = (p.var("u"), p.var("der(u)"));
    let square = p.powi(rate, 2);
    let e = p.add(u, square);
    let formula = p.notation(e);
    assert_eq!(formula.latex(), r"u + \mathrm{der(u)}^{2}");
    let dotted = formula.with_symbols(&|name| (name == "der(u)").then(|| Notation::symbol("u").dotted(1)));
    assert_eq!(dotted.latex(), r"u + \dot{u}^{2}");
}

#[test]
fn formulas_are_composed_by_hand() {
    let g = |k: u32| Notation::symbol("g").subscript(Notation::number(k));
    let bracket = |a: Notation, b: Notation| Notation::List(Joint::Comma, vec![a, b]).fenced(Fence::Brackets);
    let word = bracket(g(1), bracket(Notation::symbol("f"), g(12)));
    assert_eq!(word.latex(), "[g_{1}, [f, g_{12}]]");
    assert!(set(&word).starts_with("<mrow><mo>[</mo><mrow><msub><mi>g</mi><mn>1</mn></msub><mo>,</mo>"));

    let zero = || Notation::number(0);
    let condition = Notation::List(
        Joint::Or,
        vec![
            Notation::List(
                Joint::Wide,
                vec![
                    Notation::symbol("x1").relation(Relation::NotEqual, zero()),
                    parsed("cos(y)").relation(Relation::NotEqual, zero()),
                ],
            ),
            Notation::symbol("v").relation(Relation::Less, zero()),
        ],
    );
    assert_eq!(condition.latex(), r"x_{1} \ne 0,\ \cos\left(y\right) \ne 0\ \text{or}\ v < 0");
    assert!(condition.mathml().contains("<mi>v</mi><mo>&lt;</mo><mn>0</mn>"));

    let rows = vec![vec![Notation::number(1), Notation::number(-2.5)], vec![zero(), parsed("x")]];
    let matrix = Notation::Matrix(rows);
    assert_eq!(matrix.latex(), r"\begin{pmatrix}1 & -2.5\\ 0 & x\end{pmatrix}");
    assert!(matrix.mathml().contains("<mtr><mtd><mn>0</mn></mtd><mtd><mi>x</mi></mtd></mtr>"));
    let equation = Notation::symbol("x").dotted(1).relation(Relation::Equal, matrix);
    assert!(equation.latex_aligned().starts_with(r"\dot{x} &= \begin{pmatrix}"));
    assert_eq!(zero().latex_aligned(), "0");
    assert_eq!(Notation::column([zero(), g(2)]).latex(), r"\begin{pmatrix}0\\ g_{2}\end{pmatrix}");
}

#[test]
fn what_has_a_meaning_in_the_target_is_escaped() {
    let words = Notation::text("a_1 < b & c");
    assert_eq!(words.latex(), r"\text{a\_1 < b \& c}");
    assert_eq!(set(&words), "<mtext>a_1 &lt; b &amp; c</mtext>");
    assert_eq!(set(&Notation::symbol("a<b")), "<mi mathvariant=\"normal\">a&lt;b</mi>");
}

#[test]
fn what_is_too_large_is_named_by_its_size() {
    let mut p = Pool::new();
    let mut e = p.var("x");
    for _ in 0..30 {
        let (s, square) = (p.sin(e), p.mul(e, e));
        e = p.add(s, square);
    }
    assert!(p.latex(e).starts_with(r"\langle\text{"), "{}", p.latex(e));
    assert!(p.notation(e).mathml().contains(" nodes</mtext>"));
}

proptest! {
    #![proptest_config(cases(500))]

    /// Elements are closed in the order in which they were opened, and those with fixed places have all of them.
    #[test]
    fn mathml_is_well_formed(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 5, Kind::Any);
        let text = p.notation(e).mathml();
        prop_assert!(!text.contains('\\'), "{}", text);
        // Open elements with the number of their children so far.
        let mut open: Vec<(&str, usize)> = vec![("", 0)];
        for tag in text.split('<').skip(1).filter_map(|t| t.split('>').next()) {
            if let Some(name) = tag.strip_prefix('/') {
                let (opened, children) = open.pop().unwrap();
                prop_assert_eq!(opened, name, "{}", &text);
                let places = match name {
                    "mfrac" | "msup" | "msub" | "mover" => children == 2,
                    "msubsup" => children == 3,
                    _ => true,
                };
                prop_assert!(places, "{} has {} children in {}", name, children, &text);
            } else {
                open.last_mut().unwrap().1 += 1;
                if !tag.ends_with('/') {
                    open.push((tag.split(' ').next().unwrap(), 0));
                }
            }
        }
        prop_assert_eq!(open.len(), 1);
    }
}
