#!/usr/bin/env python3
"""Checks that every citation, such as "Chow 1939", has an entry in docs/references.md: `python3 .ci/references.py`.

Citations are those of documents, records, and models, and those in comments and strings of Rust and Python: sources, tests, benchmarks, and examples.
An entry is a line that starts with "- " and contains the names before the year, and the year. In comments, a year may also follow a title or a journal
("Chow, Mathematische Annalen 117, 1939"); the entry then has the year and its first author among the names. Exit code 1 with each citation that has none.
"""

import re
import subprocess
import sys
import unicodedata
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LIST = "docs/references.md"
WORD = r"[A-ZÀ-Ž][\w’'-]*\w"
NAME = rf"(?:(?:[Vv]an|[Vv]on|[Dd]e|[Dd]er|Da|Den|Di) )*{WORD}(?: de {WORD})?"
YEAR = r"(?:1[6-9]|20)\d\d\b(?![-\d]|\.\d)"
# Names, the last possibly with "and others" or "'s condition", and years, the first possibly in parentheses.
CITATION = re.compile(rf"\b((?:{NAME}(?:, and |, | and | & |–))*{NAME})(?:['’]s(?: [a-z]+){{1,2}}| and others| et al\.)?,? \(?({YEAR}(?:(?:, | and ){YEAR})*)")
# A year that ends a title, or the volume of a journal.
DETACHED = re.compile(rf"(?:, |\()(?!1[67])({YEAR})")
CODE = re.compile(r"`[^`]*`")
# Per kind of file, what starts a comment.
MARK = {".rs": "//", ".py": "#", ".toml": "#"}
COMMENT = {kind: re.compile(rf"(?:^|\s){mark}[/!]?(?:\s(.*))?$") for kind, mark in MARK.items()}
# Strings; comments, in which a quotation mark starts none; and characters, which may be quotation marks.
STRING = {
    ".rs": re.compile(r'''//[^\n]*|'(?:\\.|[^\\'])'|r(?P<mark>#*)"(?P<raw>.*?)"(?P=mark)|"(?P<text>(?:\\.|[^"\\])*)"''', re.DOTALL),
    ".py": re.compile(r'''#[^\n]*|(?P<mark>"""|\'\'\'|"|')(?P<text>(?:\\.|(?!(?P=mark)).)*)(?P=mark)''', re.DOTALL),
}


def plain(text: str) -> str:
    """The text without accents, in lower case."""
    return "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c)).lower()


@cache
def entry_lines(entries: str) -> list[str]:
    """The entries of a list, plain."""
    return [plain(line) for line in entries.splitlines() if line.startswith("- ")]


def one_line(text: str) -> str:
    """The text without breaks; comments of a model file are read as one line."""
    return re.sub(r"\s+", " ", re.sub(r"\n# ?", " ", text))


def citations(text: str) -> list[tuple[tuple[str, ...], str]]:
    """Names and years that a text cites."""
    return [
        (tuple(re.sub(r"['’]s$", "", name) for name in re.findall(NAME, names)), year)
        for names, years in CITATION.findall(one_line(text))
        for year in re.findall(YEAR, years)
    ]


def comments(source: str, kind: str) -> list[str]:
    """The comments of a file with a year, those on consecutive lines as one, without code in backticks."""
    found, joined = [], False
    for line in source.splitlines():
        match = COMMENT[kind].search(line)
        whole = bool(match) and line.lstrip().startswith(MARK[kind])
        if match and whole and joined:
            found[-1] += "\n" + (match[1] or "")
        elif match:
            found.append(match[1] or "")
        joined = whole
    return [CODE.sub("`", comment) for comment in found if re.search(YEAR, comment)]


def strings(source: str, kind: str) -> list[str]:
    """The strings of a Rust or Python file with a year, escaped breaks as spaces."""
    groups = [match.groupdict() for match in STRING[kind].finditer(source)]
    texts = [found["text"] or found.get("raw") or "" for found in groups]
    return [re.sub(r"\\(?:[nt]|\n\s*)", " ", text) for text in texts if re.search(YEAR, text)]


def detached(text: str) -> list[tuple[list[str], str]]:
    """Years that follow a title or a journal, with all names before them in the same parentheses."""
    line = one_line(text)
    attached = {m.start(2) + y.start() for m in CITATION.finditer(line) for y in re.finditer(YEAR, m[2])}
    found = []
    for match in DETACHED.finditer(line):
        names = re.findall(NAME, re.split(r"\(|; ", line[max(0, match.start() - 300) : match.start()])[-1])
        if match.start(1) not in attached and names:
            found.append((names, match[1]))
    return found


def has(line: str, word: str) -> bool:
    """Whether an entry has a name or year, as a word of its own."""
    return re.search(rf"(?<![\w–]){re.escape(plain(word))}(?![\w–])", line) is not None


def missing(text: str, entries: str) -> list[str]:
    """The citations of a text that no entry has."""
    lines = entry_lines(entries)
    found = {(names, year) for names, year in citations(text) if not any(all(has(line, word) for word in (*names, year)) for line in lines)}
    return [f"{', '.join(names)} {year}" for names, year in sorted(found)]


def missing_in_comments(source: str, entries: str, kind: str = ".rs") -> list[str]:
    """The citations in the comments of a file that no entry has."""
    lines = entry_lines(entries)
    found = []
    for comment in comments(source, kind):
        found += missing(comment, entries)
        for names, year in detached(comment):
            if not any(has(line, year) and any(has(re.split(r" and |, ", line)[0], name) for name in names) for line in lines):
                found.append(f"{names[0]} … {year}")
    return found


def missing_in_file(text: str, entries: str, kind: str) -> list[str]:
    """The citations of a file that no entry has; `kind` is the end of its name."""
    found = missing_in_comments(text, entries, kind) if kind in COMMENT else []
    for part in strings(text, kind) if kind in STRING else [text]:
        found += missing(part, entries)
    return sorted(set(found))


if __name__ == "__main__":
    # Test cases of this check name publications that do not exist.
    patterns = ["*.md", "*.toml", "*.rs", "*.py", f":!{LIST}", ":!.ci"]
    listed = subprocess.run(["git", "ls-files", "--", *patterns], cwd=ROOT, capture_output=True, text=True, check=True)
    entries = (ROOT / LIST).read_text(encoding="utf-8")
    found = [
        f"{name}: {citation} has no entry in {LIST}"
        for name in listed.stdout.splitlines()
        for citation in missing_in_file((ROOT / name).read_text(encoding="utf-8"), entries, Path(name).suffix)
    ]
    print("\n".join(found) or f"references: every citation has an entry in {LIST}")
    sys.exit(bool(found))
