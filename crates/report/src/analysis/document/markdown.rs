//! Markdown with formulas between dollar signs, as GitHub, Jupyter and Pandoc read it.

use super::blocks::{Block, Line, Span};

/// The whole document.
pub(super) fn written(document: &[Block]) -> String {
    let blocks: Vec<String> = document.iter().map(block).collect();
    blocks.join("\n\n") + "\n"
}

fn block(block: &Block) -> String {
    match block {
        Block::Heading(level, title) => format!("{} {}", "#".repeat(*level), plain(title)),
        Block::Paragraph(l) => line(l),
        Block::List(items) => items.iter().map(|l| format!("- {}", line(l))).collect::<Vec<_>>().join("\n"),
        Block::Display(rows) if rows.len() == 1 => format!("$$\n{}\n$$", rows[0].replacen('&', "", 1)),
        Block::Display(rows) => {
            format!("$$\n\\begin{{aligned}}\n{}\n\\end{{aligned}}\n$$", rows.join(" \\\\\n"))
        }
        Block::Table(header, rows) => {
            let row = |cells: &[Line]| {
                let cells: Vec<String> = cells.iter().map(|l| line(l).replace('|', "\\|")).collect();
                format!("| {} |", cells.join(" | "))
            };
            let mut lines = vec![row(header), format!("|{}", "---|".repeat(header.len()))];
            lines.extend(rows.iter().map(|r| row(r)));
            lines.join("\n")
        }
    }
}

fn line(line: &Line) -> String {
    line.iter()
        .map(|span| match span {
            Span::Text(t) => plain(t),
            // A bar in a formula would end the cell of a table; \vert is the same sign.
            Span::Math(m) => format!("${}$", m.replace("\\|", "\\Vert ").replace('|', "\\vert ")),
            Span::Code(c) => format!("`{c}`"),
        })
        .collect()
}

/// Words in which no sign has a meaning of its own.
fn plain(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        if matches!(c, '\\' | '`' | '*' | '_' | '#' | '<' | '>' | '$' | '[' | ']') {
            out.push('\\');
        }
        out.push(c);
    }
    out
}
