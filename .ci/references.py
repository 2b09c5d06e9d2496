#!/usr/bin/env python3
"""Checks that every citation of a document, record, or model, such as "Chow 1939", has an entry in docs/references.md: `python3 .ci/references.py`.

An entry is a line that starts with "- " and contains the name before the year, and the year. Exit code 1 with each citation that has none.
"""

import re
import subprocess
import sys
import unicodedata
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LIST = "docs/references.md"
# A name, possibly with "and others" or "'s condition", and a year, possibly in parentheses.
CITATION = re.compile(r"\b([A-ZÀ-Ž][\w’'-]*\w)(?:['’]s(?: [a-z]+){1,2}| and others| et al\.)?,? \(?((?:18|19|20)\d\d)\b(?![-\d]|\.\d)")


def plain(text: str) -> str:
    """The text without accents, in lower case."""
    return "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c)).lower()


def citations(text: str) -> list[tuple[str, str]]:
    """Names and years that a text cites; comments of a model file and broken lines are read as one line."""
    line = re.sub(r"\s+", " ", re.sub(r"\n# ?", " ", text))
    return [(re.sub(r"['’]s$", "", name), year) for name, year in CITATION.findall(line)]


def missing(text: str, entries: str) -> list[str]:
    """The citations of a text that no entry has."""
    lines = [plain(line) for line in entries.splitlines() if line.startswith("- ")]
    found = {(name, year) for name, year in citations(text) if not any(plain(name) in line and year in line for line in lines)}
    return [f"{name} {year}" for name, year in sorted(found)]


if __name__ == "__main__":
    listed = subprocess.run(["git", "ls-files", "README.md", "docs/*.md", "models/*.toml"], cwd=ROOT, capture_output=True, text=True, check=True)
    entries = (ROOT / LIST).read_text(encoding="utf-8")
    found = [
        f"{name}: {citation} has no entry in {LIST}"
        for name in listed.stdout.splitlines() if name != LIST
        for citation in missing((ROOT / name).read_text(encoding="utf-8"), entries)
    ]
    print("\n".join(found) or f"references: every citation has an entry in {LIST}")
    sys.exit(bool(found))
