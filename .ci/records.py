#!/usr/bin/env python3
"""Checks that no record is older than the program that made it.

A record says at which commit it was made. It is out of date where a later commit, or a change that is not committed, has touched
one of its programs. Exit code 1 with what to run.
"""

import datetime
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Records whose figures the README quotes: what they depend on, and the command that makes them.
RECORDS = {
    "docs/records/main_job.md": (
        ["crates/symbolic/src", "crates/system/src", "crates/sim/src", "crates/mpc/src", "crates/diagnose/src", "crates/plate/src",
         "crates/trials/src", "crates/cli/src/demo", "models/plate_move.toml", "benches/main_job"],
        "cargo build --release && python3 benches/main_job/seeds.py --record",
    ),
}
STAMP = re.compile(r"Made at commit ([0-9a-f]{7,40}) on (\d{4}-\d{2}-\d{2})")


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()


def stamp(command: str) -> str:
    """The line that a record says about its making."""
    return f"Made at commit {git('rev-parse', '--short=12', 'HEAD')} on {datetime.date.today()} by `{command}`."


def out_of_date(record: str, programs: list[str]) -> str | None:
    """Why a record is out of date, if it is."""
    found = STAMP.search((ROOT / record).read_text())
    if not found:
        return "does not say at which commit it was made"
    commit = found[1]
    if subprocess.run(["git", "cat-file", "-e", commit], cwd=ROOT, capture_output=True).returncode != 0:
        return f"was made at {commit}, which is no commit of this repository"
    later = git("log", "--format=%h %s", f"{commit}..HEAD", "--", *programs).splitlines()
    changed = git("status", "--porcelain", "--", *programs).splitlines()
    if later or changed:
        return f"was made at {commit}; since then: {'; '.join([*later, *changed][:5])}"
    return None


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
