//! The report as Markdown and LaTeX: every section, balanced formulas, the figures of the analysis.

use std::fs;

use crate::common::{bracketry, code, file, model, scratch, stdout};
use bracketry::lie::AnalysisOptions;
use bracketry::system::System;

/// The formulas between dollar signs; the text must close what it opens.
fn formulas(markdown: &str) -> Vec<String> {
    let text = markdown.replace("\\$", "");
    let parts: Vec<&str> = text.split("$$").collect();
    assert_eq!(parts.len() % 2, 1, "a display formula is not closed");
    let mut out = Vec::new();
    for (k, part) in parts.iter().enumerate() {
        if k % 2 == 1 {
            out.push((*part).to_owned());
            continue;
        }
        for line in part.lines() {
            let pieces: Vec<&str> = line.split('$').collect();
            assert_eq!(pieces.len() % 2, 1, "a formula is not closed: {line}");
            out.extend(pieces.iter().skip(1).step_by(2).map(|p| (*p).to_owned()));
        }
    }
    out
}

/// Braces, \left and \right, \begin and \end come in pairs.
fn assert_balanced(formula: &str) {
    let mut depth = 0;
    for c in formula.replace("\\{", "").replace("\\}", "").chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        assert!(depth >= 0, "{formula}");
    }
    assert_eq!(depth, 0, "{formula}");
    let count = |what: &str| formula.matches(what).count();
    assert_eq!(count("\\left") - count("\\leftarrow"), count("\\right") - count("\\rightarrow"), "{formula}");
    assert_eq!(count("\\begin{"), count("\\end{"), "{formula}");
}

const SECTIONS: [&str; 7] = [
    "Model",
    "Affine form",
    "What the inputs reach",
    "At the point",
    "Feedback linearization",
    "Observability",
    "Certificate",
];

#[test]
fn the_markdown_report_has_every_section_and_balanced_formulas() {
    let text = stdout(&["analyze", &model("plate_published.toml"), "--markdown"]);
    let headings: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("## ")).collect();
    for section in SECTIONS {
        assert!(headings.contains(&section), "{section} among {headings:?}");
    }
    let formulas = formulas(&text);
    assert!(formulas.len() > 30);
    for formula in &formulas {
        assert_balanced(formula);
    }
    // The published equations, their accelerations as derivatives, and what no input influences.
    for part in ["\\ddot{X}", "\\ddot{\\theta}", "$x + X$", "| all modes together | $10$ | $6, 10$ |"] {
        assert!(text.contains(part), "`{part}` in\n{text}");
    }
    let same = stdout(&["analyze", &model("plate_published.toml"), "--format", "markdown"]);
    // The last line has the time that it took.
    let without_time = |t: &str| t.lines().rev().skip(1).map(str::to_owned).collect::<Vec<_>>();
    assert!(without_time(&text) == without_time(&same));
}

/// A motor with a flexible shaft, its load's angle measured.
const SHAFT: &str = "name = 'shaft'\nstates = ['q', 'v', 'r', 'w']\ninputs = ['u']\n[parameters]\nk = 2\nJ = 3\n\
                     [dynamics]\nq = 'v'\nv = '-sin(q) - k*(q - r)'\nr = 'w'\nw = 'k*(q - r)/J + u/J'\n\
                     [outputs]\nangle = 'q'\n";

#[test]
fn decoupling_linearization_and_observability_stand_as_formulas() {
    let path = file(&scratch("shaft"), "shaft.toml", SHAFT);
    let text = stdout(&["analyze", &path, "--markdown", "--bracket", "[f,g1]", "--determines", "k/J"]);
    for formula in formulas(&text) {
        assert_balanced(&formula);
    }
    for part in [
        "## From inputs to outputs",
        "| $\\mathrm{angle}$ | $4$ |",
        "\\det A &= \\frac{k}{J}",
        "$f,\\ g_{1},\\ [f, g_{1}],\\ [f, [f, g_{1}]]",
        "[f, g_{1}] = \\begin{pmatrix}0\\\\ 0\\\\ -\\frac{1}{J}",
        "lengths of the chains of integrators: $4$",
        "y_{1}^{(3)} &=",
        "determined, while parameters are unknown: $\\frac{k}{J}$",
    ] {
        assert!(text.contains(part), "`{part}` in\n{text}");
    }
}

#[test]
fn without_inputs_the_report_speaks_of_the_outputs_alone() {
    let path = file(
        &scratch("free"),
        "m.toml",
        "states = ['x']\n[parameters]\na = 2\n[dynamics]\nx = '-a*x'\n[outputs]\ny = 'x'",
    );
    let text = stdout(&["analyze", &path]);
    assert!(text.contains("  no inputs\n") && text.contains("There are no inputs"), "{text}");
    let text = stdout(&["analyze", &path, "--markdown"]);
    assert!(!text.contains("Feedback linearization") && text.contains("identifiable parameters: $a$"), "{text}");
}

#[test]
fn what_is_asked_must_be_known_to_the_model() {
    for (arguments, part) in [
        (["--bracket", "[g1,g7]"], "there are f, g1, g2, s, w"),
        (["--bracket", "[g1,"], "is not a bracket"),
        (["--determines", "the"], "did you mean `th`?"),
        (["--determines", "sin("], "sin("),
    ] {
        let model = model("unicycle.toml");
        let o = bracketry(&[&["analyze", model.as_str()], &arguments[..]].concat());
        let message = String::from_utf8_lossy(&o.stderr);
        assert_eq!(code(&o), 2, "{arguments:?}");
        assert!(message.contains(part), "`{part}` in {message}");
    }
    let path = file(&scratch("no_outputs"), "m.toml", "states = ['x']\ninputs = ['u']\n[dynamics]\nx = 'u'");
    let o = bracketry(&["analyze", &path, "--determines", "x"]);
    assert_eq!(code(&o), 2);
    assert!(
        String::from_utf8_lossy(&o.stderr)
            .contains("the model has no outputs that could determine `x`: add a table [outputs]")
    );
}

#[test]
fn rows_of_a_table_have_as_many_cells_as_its_header() {
    let text = stdout(&["analyze", &model("plate_published.toml"), "--markdown"]);
    let cells = |line: &str| line.replace("\\|", "").matches('|').count();
    let lines: Vec<&str> = text.lines().collect();
    let mut tables = 0;
    for pair in lines.windows(2).filter(|w| w[0].starts_with('|') && w[1].starts_with('|')) {
        assert_eq!(cells(pair[0]), cells(pair[1]), "{}\n{}", pair[0], pair[1]);
        tables += usize::from(pair[1].starts_with("|---"));
    }
    assert_eq!(tables, 4); // parameters, ways to the affine form, ranks, what only switching reaches
}

#[test]
fn the_latex_report_is_a_document_with_the_same_formulas() {
    let text = stdout(&["analyze", &model("cart_pole.toml"), "--at", "th=pi", "--format", "latex"]);
    assert!(text.starts_with("\\documentclass{article}") && text.ends_with("\\end{document}\n"));
    assert_balanced(&text);
    assert!(text.contains("$\\mathrm{th} = \\pi$"));
    assert!(text.contains("cart\\_pole"));
}

#[test]
fn signs_with_a_meaning_in_markdown_are_escaped() {
    let text = "name = 'a_b*c'\nstates = ['x_1']\ninputs = ['u']\n[parameters]\nk = { value = 2, about = 'a | b' }\n\
                [dynamics]\nx_1 = 'k*u'";
    let system = System::parse("m", text).unwrap();
    let markdown =
        bracketry::report::analysis::markdown(&bracketry::analyze(&system, &AnalysisOptions::default()).unwrap());
    assert!(markdown.starts_with("# Analysis of a\\_b\\*c\n"), "{markdown}");
    assert!(markdown.contains("a \\| b"));
    assert!(markdown.contains("\\dot{x_{1}}"));
}

#[test]
fn the_point_on_the_command_line_replaces_that_of_the_file() {
    let dir = scratch("at");
    let path = file(&dir, "m.toml", "states = ['x']\ninputs = ['u']\n[dynamics]\nx = 'x*(1 - x)*u'\n[point]\nx = 0.5");
    let rank = |at: &[&str]| {
        let mut arguments = vec!["analyze", path.as_str(), "--json"];
        arguments.extend(at);
        crate::common::json(&arguments)["at_point"]["accessible_dimension"].clone()
    };
    assert_eq!((rank(&[]), rank(&["--at", "x=1"]), rank(&["--at", "u=1"])), (1.into(), 0.into(), 0.into()));
}

#[test]
fn a_point_that_is_none_ends_with_code_2_and_a_remedy() {
    for (at, part) in [
        ("thh=pi", "did you mean `th`?"),
        ("q9=1", "it has p, th, v, w, u"),
        ("th=M", "a point contains constants"),
        ("th", "write NAME=VALUE"),
        ("th=1,th=2", "given twice"),
        ("th=", "empty"),
    ] {
        let o = bracketry(&["analyze", &model("cart_pole.toml"), "--at", at]);
        let message = String::from_utf8_lossy(&o.stderr);
        assert_eq!(code(&o), 2, "{at}");
        assert!(message.contains(part), "`{part}` in {message}");
    }
    assert_eq!(code(&bracketry(&["analyze", &model("cart_pole.toml"), "--json", "--markdown"])), 2);
}

#[test]
fn the_folder_gets_the_report_in_three_forms() {
    let dir = scratch("report");
    let out = dir.to_str().unwrap();
    stdout(&["analyze", &model("cart_pole.toml"), "--out", out]);
    for name in [
        "analysis.json",
        "analysis.txt",
        "analysis.md",
        "affine.toml",
        "growth.svg",
        "growth.png",
        "reach.svg",
        "reach.png",
    ] {
        assert!(fs::metadata(dir.join(name)).unwrap().len() > 0, "{name}");
    }
    assert!(fs::read_to_string(dir.join("analysis.md")).unwrap().starts_with("# Analysis of cart\\_pole"));
}

#[test]
fn the_pictures_name_the_brackets_and_what_is_never_reached() {
    let dir = scratch("pictures");
    stdout(&["analyze", &model("plate_published.toml"), "--out", dir.to_str().unwrap()]);
    let growth = fs::read_to_string(dir.join("growth.svg")).unwrap();
    for part in ["[f,g1]", "[f,[f,g2]]", "not reached", "all modes together", "bracket length"] {
        assert!(growth.contains(part), "{part}");
    }
    let reach = fs::read_to_string(dir.join("reach.svg")).unwrap();
    for part in ["vx + Xd", "influenced by no input", "can be moved alone", "what switching adds"] {
        assert!(reach.contains(part), "{part}");
    }
    // A system without anything unreachable does not speak of it.
    stdout(&["analyze", &model("unicycle.toml"), "--out", dir.to_str().unwrap()]);
    let growth = fs::read_to_string(dir.join("growth.svg")).unwrap();
    assert!(growth.contains("[g1,g2]") && !growth.contains("not reached"));
}
