//! A linear system in the languages of other programs.

use bracketry_lie::operating::LinearModel;
use nalgebra::DMatrix;
use std::fmt::Write as _;

use super::text::delayed;

/// A file with its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinearFile {
    /// Name without folder.
    pub name: &'static str,
    /// Contents.
    pub text: String,
}

/// Numbers that read back exactly.
fn rows(m: &DMatrix<f64>, separator: &str, row: impl Fn(String) -> String) -> Vec<String> {
    m.row_iter().map(|r| row(r.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(separator))).collect()
}

/// `linear.py` for python-control, `linear.m` for MATLAB and Octave, and `linear.jl` for Julia's ControlSystems: each makes
/// A, B, C, D and the system `sys`, with the names of states, inputs, and outputs where the program takes them.
pub fn linear_files(model: &LinearModel) -> Vec<LinearFile> {
    let all = [("A", &model.a.values), ("B", &model.b.values), ("C", &model.c.values), ("D", &model.d.values)];
    let quoted = |list: &[String]| list.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
    let single = |list: &[String]| list.iter().map(|n| format!("'{n}'")).collect::<Vec<_>>().join(", ");
    let mut python = format!("# {}: x' = A x + B u, y = C x + D u\nimport numpy as np\n", model.model);
    let mut matlab = format!("% {}: x' = A x + B u, y = C x + D u\n", model.model);
    let mut julia = format!("# {}: x' = A x + B u, y = C x + D u\n", model.model);
    if let Some(delays) = delayed(model) {
        let _ = writeln!(python, "# {delays}");
        let _ = writeln!(matlab, "% {delays}");
        let _ = writeln!(julia, "# {delays}");
    }
    for (name, m) in all {
        let (n, p) = m.shape();
        let list = rows(m, ", ", |r| format!("[{r}]")).join(",\n     ");
        let _ = writeln!(python, "{name} = np.array([{list}]).reshape({n}, {p})");
        if m.is_empty() {
            let _ = writeln!(matlab, "{name} = zeros({n}, {p});");
            let _ = writeln!(julia, "{name} = zeros({n}, {p})");
        } else {
            let _ = writeln!(matlab, "{name} = [{}];", rows(m, ", ", |r| r).join("; "));
            let _ = writeln!(julia, "{name} = reshape([{}], {p}, {n})' |> Matrix", rows(m, ", ", |r| r).join(", "));
        }
    }
    let _ = write!(
        python,
        "states = [{}]\ninputs = [{}]\noutputs = [{}]\n\nif __name__ == \"__main__\":\n    import control\n\n    sys = control.ss(A, B, C, D, states=states, inputs=inputs, outputs=outputs)\n    print(sys)\n",
        quoted(&model.states),
        quoted(&model.inputs),
        quoted(&model.outputs)
    );
    let _ = writeln!(
        matlab,
        "sys = ss(A, B, C, D, 'StateName', {{{}}}, 'InputName', {{{}}}, 'OutputName', {{{}}});",
        single(&model.states),
        single(&model.inputs),
        single(&model.outputs)
    );
    let _ = write!(
        julia,
        "state_names = [{}]\ninput_names = [{}]\noutput_names = [{}]\nusing ControlSystems\nsys = ss(A, B, C, D)\n",
        quoted(&model.states),
        quoted(&model.inputs),
        quoted(&model.outputs)
    );
    vec![
        LinearFile { name: "linear.py", text: python },
        LinearFile { name: "linear.m", text: matlab },
        LinearFile { name: "linear.jl", text: julia },
    ]
}
