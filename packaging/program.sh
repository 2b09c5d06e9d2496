#!/usr/bin/env bash
# The command as an archive in dist/: program, licenses (also of the crates and of the font in it), models, shell completions, manual pages.
# The argument is the target (this machine's if left out).
set -euo pipefail
cd "$(dirname "$0")/.."
target=${1:-$(rustc -vV | sed -n 's/^host: //p')}
rustup target add "$target" >/dev/null 2>&1 || true   # present where it is the machine's own
cargo build --release --locked --bin bracketry --target "$target"
folder=bracketry-$target
built=${CARGO_TARGET_DIR:-target}/$target/release
rm -rf "dist/$folder" && mkdir -p "dist/$folder/completions" "dist/$folder/man"
case $target in
    *windows*) program=bracketry.exe ;;
    *) program=bracketry ;;
esac
cp "$built/$program" "dist/$folder/"
cp crates/README.md "dist/$folder/README.md"
cp -r LICENSE-MIT LICENSE-APACHE CITATION.cff models crates/plot/assets/LICENSE-DejaVu.txt "dist/$folder/"
# The models name documents.
mkdir "dist/$folder/docs" && cp -r docs/*.md docs/figures docs/getting_started docs/records "dist/$folder/docs/"
cp CHANGELOG.md CODE_OF_CONDUCT.md CONTRIBUTING.md SECURITY.md "dist/$folder/"
packaging/licenses.py bracketry-cli "dist/$folder/THIRDPARTY.txt"
for shell in bash zsh fish; do
    "$built/$program" completions "$shell" >"dist/$folder/completions/bracketry.$shell"
done
"$built/$program" man --out "dist/$folder/man" >/dev/null
"dist/$folder/$program" analyze "dist/$folder/models/unicycle.toml" >/dev/null
case $target in
    *windows*) (cd dist && 7z a -bd "$folder.zip" "$folder" >/dev/null) ;;
    *) tar -C dist -czf "dist/$folder.tgz" "$folder" ;;
esac
rm -rf "dist/$folder"
ls -l dist/"$folder".*
