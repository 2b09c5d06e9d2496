//! A LaTeX document of its own.

use super::blocks::{Block, Line, Span};

/// The whole document.
pub(super) fn written(document: &[Block]) -> String {
    let body: Vec<String> = document.iter().map(block).collect();
    format!(
        "\\documentclass{{article}}\n\\usepackage[a4paper,margin=25mm]{{geometry}}\n\\usepackage{{amsmath}}\n\
         \\setlength{{\\parindent}}{{0pt}}\n\\setlength{{\\parskip}}{{1ex}}\n\\allowdisplaybreaks\n\
         \\begin{{document}}\n\n{}\n\n\\end{{document}}\n",
        body.join("\n\n")
    )
}

fn block(block: &Block) -> String {
    match block {
        Block::Heading(1, title) => format!("\\section*{{{}}}", plain(title)),
        Block::Heading(_, title) => format!("\\subsection*{{{}}}", plain(title)),
        Block::Paragraph(l) => line(l),
        Block::List(items) => {
            let items: Vec<String> = items.iter().map(|l| format!("\\item {}", line(l))).collect();
            format!("\\begin{{itemize}}\n{}\n\\end{{itemize}}", items.join("\n"))
        }
        Block::Display(rows) => format!("\\begin{{align*}}\n{}\n\\end{{align*}}", rows.join(" \\\\\n")),
        Block::Table(header, rows) => {
            let row = |cells: &[Line]| cells.iter().map(line).collect::<Vec<_>>().join(" & ");
            let rows: Vec<String> = rows.iter().map(|r| format!("{} \\\\", row(r))).collect();
            format!(
                "\\begin{{tabular}}{{{}}}\n{} \\\\\n\\hline\n{}\n\\end{{tabular}}",
                "l".repeat(header.len()),
                row(header),
                rows.join("\n")
            )
        }
    }
}

fn line(line: &Line) -> String {
    line.iter()
        .map(|span| match span {
            Span::Text(t) => plain(t),
            Span::Math(m) => format!("${m}$"),
            Span::Code(c) => format!("\\texttt{{{}}}", plain(c)),
        })
        .collect()
}

/// Words in which no sign has a meaning of its own.
fn plain(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', c]),
            '\\' => out.push_str("\\textbackslash{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '<' | '>' => out.extend(['$', c, '$']),
            '≥' => out.push_str("$\\ge$"),
            '≤' => out.push_str("$\\le$"),
            '≠' => out.push_str("$\\ne$"),
            '−' => out.push_str("$-$"),
            'σ' => out.push_str("$\\sigma$"),
            _ => out.push(c),
        }
    }
    out
}
