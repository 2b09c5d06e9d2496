#!/bin/sh
# Makes the seed corpora of the fuzz targets from the models, the documents and a few lines of tables.
set -e
cd "$(dirname "$0")"
for target in expression model problem table archive robot; do mkdir -p "corpus/$target"; done
cp ../models/*.toml corpus/model
for file in ../models/*.toml; do
    if grep -q '^model *=' "$file"; then cp "$file" corpus/problem; fi
    if grep -q '^convention\|^urdf' "$file"; then cp "$file" corpus/robot; fi
done
# What stands in quotes after an equals sign in the models and documents, one expression a file.
n=0
sed -n 's/^[^#"]*= *"\([^"]*\)".*/\1/p' ../models/*.toml ../docs/*.md ../README.md | sort -u | while IFS= read -r text; do
    n=$((n + 1))
    printf '%s' "$text" >"corpus/expression/$n"
done
# The problem of each document, one block a file.
awk '/^```toml/ { n++; on = 1; next } /^```/ { on = 0 } on { print > ("corpus/problem/block-" n ".toml") }' ../docs/mpc*.md
cp corpus/problem/block-*.toml corpus/model
for d in 0 1 2 3; do
    printf 't,x,u,y,"der(X,2)"\n0,0.%s,1,0,0\n0.1,0.%s5,1,nan,0\n0.2,,-1,0.2,0\n0.3,1e%s,0,0.1,1\n' $d $d $d >"corpus/table/$d"
done
for sample in '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 1" rpy="0 0.1 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'; do
    printf '%s' "$sample" >corpus/robot/description.urdf
done
python3 - <<'P'
import io, struct, zipfile

def array(descr, data, shape):
    header = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}"
    header = header.ljust((64 - 10 - 1) % 64 + len(header) // 64 * 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + data

for name, method in (("stored", zipfile.ZIP_STORED), ("deflated", zipfile.ZIP_DEFLATED)):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as z:
        z.writestr("t.npy", array("<f8", struct.pack("<4d", 0, 0.1, 0.2, 0.3), "(4,)"))
        z.writestr("x.npy", array("<f4", struct.pack("<4f", 0, 1, 2, 3), "(4, 1)"))
        z.writestr("u.npy", array("<i2", struct.pack("<4h", 0, 1, 0, 1), "(4,)"))
    open(f"corpus/archive/{name}.npz", "wb").write(out.getvalue())
P
