//! Formulas of documents and pages: equations, conditions, and brackets as they are set.

use bracketry_lie::algebra::{Bracket, Generator, Word};
use bracketry_lie::analysis::RequestedBracket;
use bracketry_lie::{Analysis, AnalysisOptions, Answer, Condition, Function, analyze};
use bracketry_report::analysis::{latex, markdown};
use bracketry_report::html;
use bracketry_symbolic::Pool;
use bracketry_system::System;

fn function(text: &str) -> Function {
    let mut pool = Pool::new();
    let e = pool.parse(text).unwrap();
    Function::new(&pool, e)
}

/// An analysis with an output, whose findings can be replaced.
fn analysis() -> Analysis {
    let text = "states = ['x']\ninputs = ['u']\noutputs = { y = 'x' }\n[dynamics]\nx = 'u'";
    analyze(&System::parse("m", text).unwrap(), &AnalysisOptions::default()).unwrap()
}

#[test]
fn derivatives_of_inputs_have_dots() {
    let text = "states = ['x']\ninputs = ['u', 'uu']\n[dynamics]\nx = 'der(u)^2 + der(uu, 3)*sin(u)'";
    let system = System::parse("m", text).unwrap();
    let document = markdown(&analyze(&system, &AnalysisOptions::default()).unwrap());
    let set = document.lines().find(|line| line.contains("\\dot{x} &=") || line.contains("\\dot{x} =")).unwrap();
    assert!(set.contains("\\dot{u}^{2}") && set.contains("{\\mathrm{uu}}^{(3)}"), "{set}");
    assert!(!set.contains("der"), "{set}");
    let page = html::equations(&system);
    assert!(page.contains("u\u{307}</mi><mn>2</mn></msup>") && page.contains("<mo>\u{20db}</mo>"), "{page}");
    assert!(!page.contains("der"), "{page}");
}

#[test]
fn names_stay_as_they_are_written() {
    assert!(html::symbol("a<b").contains("a&lt;b"));
}

#[test]
fn conditions_keep_their_words_and_signs() {
    use Condition::{All, Any, Differs, Positive, Vanishes};
    let mut a = analysis();
    let both = All(vec![Differs(function("x1")), Differs(function("cos(y)"))]);
    for (set, formula) in [
        (Vanishes(function("v")), "v = 0"),
        (both, "x_{1} \\ne 0,\\ \\cos\\left(y\\right) \\ne 0"),
        (Any(vec![Vanishes(function("a")), Positive(function("b"))]), "a = 0\\ \\text{or}\\ b > 0"),
    ] {
        a.report.control.input_output.as_mut().unwrap().singular_set = Some(set);
        let document = markdown(&a);
        assert!(document.contains(&format!("A is singular where ${formula}$\n")), "{formula} in {document}");
    }
}

#[test]
fn brackets_have_indices() {
    let [f, g] = [0, 1].map(Word::Generator);
    let nested = Word::bracket(g.clone(), Word::bracket(f.clone(), g.clone()));
    let input = |input, mode| Generator::Input { input, mode };
    let mut a = analysis();
    for (word, generators, formula) in [
        (nested, [Generator::Drift { mode: None }, input(12, None)], "[g_{12}, [f, g_{12}]]"),
        (
            Word::bracket(f, g),
            [Generator::DriftDifference { mode: 3 }, input(2, Some(4))],
            "[f^{(3)}-f^{(1)}, g_{2}^{(4)}]",
        ),
    ] {
        a.report.brackets = vec![RequestedBracket {
            name: String::new(),
            bracket: Bracket { word, generators: generators.into() },
            components: Answer::Known(vec![function("x")]),
        }];
        let document = latex(&a);
        assert!(document.contains(&format!("{formula} &= \\begin{{pmatrix}}x\\end{{pmatrix}}")), "{document}");
    }
}
