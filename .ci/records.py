#!/usr/bin/env python3
"""Checks that no record is older than the program that made it.

A record says at which commit it was made, and gives a digest of the programs that made it. It is out of date where these have
changed since. Exit code 1 with what to run.
"""

import datetime
import hashlib
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Records whose figures the README quotes: what they depend on, and the command that makes them.
RECORDS = {
    "docs/records/main_job.md": (
        ["crates/symbolic/src", "crates/system/src", "crates/sim/src", "crates/mpc/src", "crates/diagnose/src", "crates/plate/src",
         "crates/cli/src/demo", "models/plate_move.toml", "benches/main_job"],
        "cargo build --release && python3 benches/main_job/seeds.py --record; --confirm instead where results stay as they are",
    ),
}
STAMP = re.compile(r"Made at commit ([0-9a-f]{7,40}) on (\d{4}-\d{2}-\d{2}) by `[^`]+`, programs ([0-9a-f]{16})")


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()


def digest(programs: list[str]) -> str:
    """Of the contents of the programs: the same in every clone, whatever became of its commits."""
    whole = hashlib.sha256()
    for program in programs:
        path = ROOT / program
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file() and "__pycache__" not in file.parts:
                whole.update(f"{file.relative_to(ROOT).as_posix()}\n".encode())
                whole.update(file.read_bytes())
    return whole.hexdigest()[:16]


def stamp(command: str, programs: list[str]) -> str:
    """The line that a record says about its making."""
    made = f"Made at commit {git('rev-parse', '--short=12', 'HEAD')} on {datetime.date.today()}"
    return f"{made} by `{command}`, programs {digest(programs)}."


def out_of_date(record: str, programs: list[str]) -> str | None:
    """Why a record is out of date, if it is."""
    found = STAMP.search((ROOT / record).read_text())
    if not found:
        return "does not say at which commit it was made"
    if found[3] == digest(programs):
        return None
    why = f"was made at {found[1]} on {found[2]}, of other programs"
    if subprocess.run(["git", "cat-file", "-e", found[1]], cwd=ROOT, capture_output=True).returncode == 0:
        later = git("log", "--format=%h %s", f"{found[1]}..HEAD", "--", *programs).splitlines()
        changed = git("status", "--porcelain", "--", *programs).splitlines()
        why += f"; since then: {'; '.join([*later, *changed][:5])}"
    return why


def main() -> int:
    code = 0
    for record, (programs, command) in RECORDS.items():
        if not all((ROOT / program).exists() for program in programs):
            print(f"{record}: names a program that does not exist", file=sys.stderr)
            code = 1
            continue
        why = out_of_date(record, programs)
        if why:
            print(f"{record} {why}\n   = {command}", file=sys.stderr)
            code = 1
    return code


if __name__ == "__main__":
    sys.exit(main())
