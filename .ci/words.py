#!/usr/bin/env python3
"""Holds code and documents to American spelling, standard terms, and native turns of phrase: `python3 .ci/words.py`.

Prints each place with the word to use and ends with 1 if there is one. Keys of files, JSON, and Python that keep an older spelling are exempt.
"""

import re
import subprocess
import sys
import time
from pathlib import Path

IZE = "linear stabil neutral general summar optim minim maxim discret raster symmetr regular memo vector normal parametr"
SPELLING = {
    "colour": "color", "behaviour": "behavior", "neighbour": "neighbor", "favour": "favor", "honour": "honor",
    "centre": "center", "centring": "centering", "metres": "meters", "millimetre": "millimeter", "towards": "toward",
    "modelled": "modeled", "modelling": "modeling", "labelled": "labeled", "cancelled": "canceled", "travelled": "traveled",
    "cancelling": "canceling", "licence": "license", "artefact": "artifact", "judgement": "judgment", "whilst": "while",
    "analysed": "analyzed", "analysing": "analyzing",
    **{stem + "is": stem + "iz…" for stem in IZE.split()},
}
# Private words of older texts, in the forms that are not also plain English, with the standard terms.
TERMS = {
    "badness": "cost or objective", "strayed": "diverged", "exhausts": "spans", "investigated": "examined", "begun": "started",
    "leaves over": "residual, leaves", "leave over": "residual, leave", "stands out of": "is significant",
    "stand out of": "be significant", "fn carry(": "propagate or transfer", "fn again(": "refit",
}
# Turns that read as translated, with what a native writer says.
TURNS = {
    "exactly if": "if and only if", "just if": "if and only if", "does not name is 0": "unnamed states are 0", "is absent is 0": "unnamed states are 0", "not named is 0": "unnamed states are 0",
    "of no importance": "does not matter", "with their place (": "with line and column", "refused with their place": "rejected with line and column",
    "is singular but where": "singular only where", "nothing is trusted": "not trusted but verified", "made up for": "compensated",
    "number is believed": "is accepted", "prove something of": "certificates for", "program per sample settles": "one QP per sample suffices",
    "violated by at most": "all kept, or largest violation", "none found: unknown": "none found (undecided)",
    "believed in": "assumed", "brings the command along": "includes the command",
}
# The same in documents alone, outside of code: names of tests and comments keep them.
DOCUMENT_TURNS = {
    "believed": "assumed", "inputs within bounds": "bounded inputs", "beside the": "next to, near, or compared with the",
    "from where it is": "from the current state", "brings its own": "has its own", "as good as a plan": "costs what a converged plan costs",
    "from what the loop did": "from the inputs that the loop applied", "are looked for": "the search includes", "hostile": "adversarial or untrusted",
    "anew": "again, or regenerate", "upwards": "upward", "refused": "rejected", "broken off": "aborted", "as promised": "passes",
    "main job": "plate demonstration", "searches on": "continues the search", "only grow": "are only extended",
}
CODE = re.compile(r"`[^`]*`|\]\([^)]*\)")
WORDS = SPELLING | TERMS | TURNS
# Names of interfaces, which stay, and mistakes that a test makes on purpose.
EXEMPT = re.compile(
    r'"centre(_deviation)?"|`centre`|centre = \[|`?centre_of_mass|"linearisation"|"linearise"|"analyse"|Mod(elling|elled), |fn carry\(&mut self, load|centre manifold theory|towards fair|modelling valve stiction|biological modelling|control, optimisation and calculus'
)
SUFFIXES = {".rs", ".md", ".toml", ".py", ".pyi", ".ipynb", ".html", ".cff", ".sh"}
SKIPPED = ("docs/glossary.md", ".ci/words.py")


def places(root: Path):
    names = subprocess.run(["git", "ls-files"], cwd=root, capture_output=True, text=True, check=True).stdout.splitlines()
    for name in names:
        if name in SKIPPED or Path(name).suffix not in SUFFIXES:
            continue
        text = (root / name).read_text(encoding="utf-8").lower()
        if name.startswith("crates/python/"):
            text = re.sub(r"\bcentre(_deviation)?\b", "", text)  # attributes of bracketry.stiffness.Weighing
        document = Path(name).suffix == ".md"
        turns = WORDS | DOCUMENT_TURNS if document else WORDS
        found = [word for word in turns if word in text]
        if not found:
            continue
        for number, line in enumerate(text.splitlines(), 1):
            line = EXEMPT.sub("", line)
            for word in found:
                if word in (CODE.sub("", line) if word in DOCUMENT_TURNS else line):
                    yield f"{name}:{number}: `{word}`: write {turns[word]}"


if __name__ == "__main__":
    start = time.perf_counter()
    found = list(places(Path(__file__).resolve().parent.parent))
    print("\n".join(found) or f"words: American spelling and the glossary's terms ({time.perf_counter() - start:.2f} s)")
    sys.exit(bool(found))
