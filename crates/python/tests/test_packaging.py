"""What is published: workflows, recipe, citation, texts, and metadata parse, name what exists, and agree with each other."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

import bracketry

if sys.version_info >= (3, 11):
    import tomllib
else:
    tomllib = pytest.importorskip("tomli")

ROOT = Path(__file__).resolve().parents[3]
CARGO = tomllib.loads((ROOT / "Cargo.toml").read_text())
REPOSITORY = CARGO["workspace"]["package"]["repository"]
YAML = sorted((ROOT / ".github").rglob("*.yml")) + [ROOT / "packaging/conda/recipe.yaml", ROOT / "CITATION.cff"]
#: Where a developer finds a command of a workflow.
DOCUMENTED = [(ROOT / name).read_text() for name in (".ci/run", "README.md", "docs/README.md", "CONTRIBUTING.md")]


def runs(workflow: Path) -> list[str]:
    jobs = yaml.safe_load(workflow.read_text())["jobs"].values()
    return [step["run"] for job in jobs for step in job["steps"] if "run" in step]


@pytest.mark.parametrize("file", YAML, ids=lambda f: f.name)
def test_it_parses(file: Path) -> None:
    assert yaml.safe_load(file.read_text())


@pytest.mark.parametrize("workflow", sorted((ROOT / ".github/workflows").glob("*.yml")), ids=lambda f: f.stem)
def test_a_step_is_what_a_developer_runs_too(workflow: Path) -> None:
    steps = runs(workflow)
    assert steps
    for step in steps:
        program, *rest = step.split()
        if (ROOT / program).is_file():
            assert (ROOT / program).stat().st_mode & 0o111, program
            assert program == ".ci/run" or any(program in text for text in DOCUMENTED), f"{program} is in no document"
        elif program in ("git", "gh"):
            assert rest
            if rest[:2] == ["release", "upload"]:
                creates = any("gh release create" in s for s in steps)
                assert creates, "a tag alone makes no release to upload to"
        else:
            assert any(step in text for text in DOCUMENTED), f"`{step}` is in no document"


def test_versions_agree() -> None:
    version = CARGO["workspace"]["package"]["version"]
    assert bracketry.__version__ == version
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == version
    assert yaml.safe_load((ROOT / "packaging/conda/recipe.yaml").read_text())["context"]["version"] == version
    tag = subprocess.run([ROOT / "packaging/tagged.sh", f"v{version}"], capture_output=True, text=True)
    assert tag.returncode == 0, tag.stderr
    wrong = subprocess.run([ROOT / "packaging/tagged.sh", "v0.0.0"], capture_output=True, text=True)
    assert wrong.returncode == 1 and "v0.0.0" in wrong.stderr


def test_licenses_of_linked_crates_are_collected(tmp_path: Path) -> None:
    file = tmp_path / "THIRDPARTY.txt"
    subprocess.run([sys.executable, ROOT / "packaging/licenses.py", "bracketry-cli", file], check=True)
    text = file.read_text(encoding="utf-8")
    assert re.search(r"^clap [0-9.]+: MIT OR Apache-2.0$", text, re.M) and "Permission is hereby granted" in text
    assert not re.search(r"^bracketry", text, re.M)


def test_there_is_one_address() -> None:
    files = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    named = 0
    for name in files:
        path = ROOT / name
        if path.suffix not in (".md", ".toml", ".yml", ".yaml", ".cff", ".rs", ".py") or path.is_symlink():
            continue
        for url in re.findall(r"https://github\.com/bracketry/[\w./-]*", path.read_text()):
            named += 1
            assert url.startswith(REPOSITORY), f"{name}: {url}"
            if inside := re.match(re.escape(REPOSITORY) + "/blob/(?:main|v[0-9.]+)/(.*)", url):
                assert (ROOT / inside[1]).exists(), f"{name}: {url}"
    assert named > 20


@pytest.mark.parametrize("name", ["crates/README.md", "crates/python/README.md"])
def test_texts_of_registries_have_no_relative_links(name: str) -> None:
    links = re.findall(r"\]\(([^)]*)\)", (ROOT / name).read_text())
    assert links and all(link.startswith("https://") for link in links), links


def test_manifests_are_complete() -> None:
    published = 0
    for manifest in [ROOT / "Cargo.toml", *(ROOT / "crates").glob("*/Cargo.toml")]:
        package = tomllib.loads(manifest.read_text())["package"]
        keys = {"description", "version", "edition", "rust-version", "license", "authors", "repository", "homepage"}
        if package.get("publish") is not False:
            published += 1
            keys |= {"readme", "documentation", "keywords", "categories"}
            assert all((manifest.parent / text).is_file() for text in ("LICENSE-MIT", "LICENSE-APACHE")), manifest
        assert keys <= package.keys(), f"{manifest}: {keys - package.keys()}"
    assert published == 20
