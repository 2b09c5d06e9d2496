//! The limits of memory and time at the command line: what is undecided within them is unknown, and what does not end within them is
//! ended, with exit code 1 and the option to raise.

use crate::common::{bracketry, code, file, scratch, text};

/// Phases on a ring that attract each other: their brackets become long.
fn oscillators(n: usize) -> String {
    let rate = |i: usize| {
        let [next, last] = [(i + 1) % n, (i + n - 1) % n];
        let input = if i == 0 { " + u" } else { "" };
        format!("x{i} = 'sin(x{next} - x{i}) + sin(x{last} - x{i}){input}'")
    };
    let names: Vec<String> = (0..n).map(|i| format!("'x{i}'")).collect();
    let rates: Vec<String> = (0..n).map(rate).collect();
    format!("states = [{}]\ninputs = ['u']\n[dynamics]\n{}\n", names.join(", "), rates.join("\n"))
}

#[test]
fn beyond_its_memory_an_analysis_is_unknown_or_ends_and_names_the_option() {
    let model = file(&scratch("memory_limit"), "ring.toml", &oscillators(40));
    // Far below what any process takes: the process ends.
    let o = bracketry(&["analyze", &model, "--memory-limit", "1MB"]);
    let said = text(&o.stdout) + &text(&o.stderr);
    assert!(code(&o) == 1 && said.contains("memory limit of 0.001 GB") && said.contains("--memory-limit"), "{said}");
    // Enough for the model, less than all questions take: a report that says so, or the same end.
    let o = bracketry(&["analyze", &model, "--memory-limit", "60MB"]);
    let said = text(&o.stdout) + &text(&o.stderr);
    assert!(code(&o) < 2 && said.contains("memory limit"), "{said}");
}

#[test]
fn limits_are_a_size_with_a_unit_and_a_positive_time_for_every_command() {
    let model = file(&scratch("bad_limits"), "ring.toml", &oscillators(2));
    for size in ["3", "GB", "-1GB", "1XB", "nanGB", "1kB", "0GB"] {
        let o = bracketry(&["analyze", &model, &format!("--memory-limit={size}")]);
        assert!(code(&o) == 2 && text(&o.stderr).contains("give"), "{size}: {}", text(&o.stderr));
    }
    let commands: [&[&str]; 7] = [
        &["analyze"],
        &["affinize"],
        &["trim"],
        &["linearize"],
        &["certify"],
        &["transform", "--to", "kalman"],
        &["steer", "--to", "x0=1"],
    ];
    for command in commands {
        for time in ["0", "-1", "nan", "x"] {
            let o = bracketry(&[command, &[&model, "--time-limit", time]].concat());
            let said = text(&o.stderr);
            assert!(code(&o) == 2 && said.contains("positive number of seconds"), "{command:?} {time}: {said}");
        }
        let o = bracketry(&[command, &[&model, "--time-limit", "1e30", "--memory-limit", "8GiB"]].concat());
        assert_ne!(code(&o), 2, "{command:?}: {}", text(&o.stderr));
    }
}
