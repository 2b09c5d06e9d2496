//! `bracketry completions` and `bracketry man`: what a shell and the manual know of the commands.

use std::path::Path;

use anyhow::Context;
use clap::Args;
use clap_complete::Shell;
use clap_mangen::Man;

use super::output::{folder, line, print};
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const COMPLETION_EXAMPLES: [(&str, &str); 3] = [
    (
        "bash (create the folder first)",
        "bracketry completions bash > ~/.local/share/bash-completion/completions/bracketry",
    ),
    (
        "zsh (create ~/.zfunc first, and put fpath+=~/.zfunc before compinit)",
        "bracketry completions zsh > ~/.zfunc/_bracketry",
    ),
    ("fish", "bracketry completions fish > ~/.config/fish/completions/bracketry.fish"),
];

/// Shown by the help.
pub(crate) const MAN_EXAMPLES: [(&str, &str); 2] = [
    ("Read a page", "bracketry man diagnose | man -l -"),
    ("Install all of them", "bracketry man --out ~/.local/share/man/man1"),
];

/// Arguments of `completions`.
#[derive(Args)]
pub(crate) struct CompletionsArgs {
    /// Shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Args)]
pub(crate) struct ManArgs {
    /// Command whose page to print, such as `stiffness identify`; by default that of the program
    command: Vec<String>,
}

/// Prints the completion script of a shell for the whole command line.
pub(crate) fn completions(
    args: &CompletionsArgs,
    root: &mut clap::Command,
    output: &CommonArgs,
) -> anyhow::Result<Outcome> {
    no_json(output, "completions prints a script for a shell")?;
    let mut script = Vec::new();
    clap_complete::generate(args.shell, root, "bracketry", &mut script);
    print(&String::from_utf8(script)?)?;
    Ok(Outcome::Done)
}

/// Prints a manual page of the whole command line, or writes all of them.
pub(crate) fn man(args: &ManArgs, mut root: clap::Command, output: &CommonArgs) -> anyhow::Result<Outcome> {
    no_json(output, "manual pages are not data")?;
    // From here on, names and usage of nested commands include those of their parents.
    root.build();
    if let Some(dir) = &output.out {
        if let Some(word) = args.command.first() {
            anyhow::bail!("man {word} --out: --out writes all pages; omit `{word}` or --out");
        }
        folder(dir)?;
        let pages = write_pages(&root, "bracketry", dir)?;
        line(&format!("{pages} pages written to {}", dir.display()))?;
        return Ok(Outcome::Done);
    }
    let mut path = vec!["bracketry"];
    let mut command = &root;
    for word in &args.command {
        command = command.find_subcommand(word).with_context(|| {
            let known: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
            let path = path.join(" ");
            match known.as_slice() {
                [] => format!("there is no command `{path} {word}`: `{path}` has no commands of its own"),
                known => format!("there is no command `{path} {word}`: the commands are {}", known.join(", ")),
            }
        })?;
        path.push(word);
    }
    print(&page(command, &path.join("-"))?)?;
    Ok(Outcome::Done)
}

fn no_json(output: &CommonArgs, why: &str) -> anyhow::Result<()> {
    anyhow::ensure!(!output.json, "--json: {why}; omit it");
    Ok(())
}

fn page(command: &clap::Command, name: &str) -> anyhow::Result<String> {
    let mut command = command.clone().version(env!("CARGO_PKG_VERSION"));
    let usage = command.render_usage().to_string();
    let command = command.override_usage(usage.trim_start_matches("Usage: ").to_owned());
    let source = concat!("bracketry ", env!("CARGO_PKG_VERSION"));
    let mut text = Vec::new();
    Man::new(command).title(name).source(source).render(&mut text)?;
    Ok(String::from_utf8(text)?)
}

/// Writes the page of a command and of those below it; gives their number.
fn write_pages(command: &clap::Command, name: &str, dir: &Path) -> anyhow::Result<usize> {
    super::output::write(&dir.join(format!("{name}.1")), &page(command, name)?)?;
    let mut pages = 1;
    for below in command.get_subcommands().filter(|c| c.get_name() != "help") {
        pages += write_pages(below, &format!("{name}-{}", below.get_name()), dir)?;
    }
    Ok(pages)
}
