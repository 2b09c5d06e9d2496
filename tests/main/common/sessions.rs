//! What a document shows: blocks of a kind, and sessions at the command line, commands with the lines printed below them.

/// The blocks of a kind.
pub(crate) fn blocks(document: &str, kind: &str) -> Vec<String> {
    let fence = format!("```{kind}\n");
    document.split(&fence).skip(1).map(|part| part.split("```").next().unwrap().to_owned()).collect()
}

/// Commands and the lines shown below them; the blocks are fenced as `console`.
pub(crate) fn sessions(document: &str) -> Vec<(Vec<String>, Vec<String>)> {
    let mut out = Vec::new();
    for block in document.split("```console\n").skip(1) {
        let block = block.split("```").next().unwrap();
        let mut lines = block.lines();
        let command = lines.next().unwrap().strip_prefix("$ bracketry ").unwrap();
        out.push((command.split(' ').map(str::to_owned).collect(), lines.map(str::to_owned).collect()));
    }
    out
}

/// The first line shown that does not follow in what was printed; `…` stands for any lines, also none.
pub(crate) fn first_difference(shown: &[String], printed: &str) -> Option<String> {
    let mut rest = printed.lines();
    let mut gap = false;
    for line in shown {
        if line == "…" {
            gap = true;
        } else {
            let found = if gap { rest.any(|l| l == line) } else { rest.next() == Some(line.as_str()) };
            if !found {
                return Some(line.clone());
            }
            gap = false;
        }
    }
    (!gap && rest.next().is_some()).then(|| "more lines".to_owned())
}
