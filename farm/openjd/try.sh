#!/bin/sh
# Checks the templates of this folder with `openjd` (pip install openjd-cli) and runs them: a picture in parts and a film in chunks of frames, with
# paths mapped, held against what one machine makes. Exit code 0: all of it is right. The program is $BHS, or the repository's.
set -eu

here=$(cd -- "$(dirname -- "$0")" && pwd)
BHS=${BHS:-${here%/farm/openjd}/target/release/bhs}
die() {
    printf 'error: %s\n' "$*" >&2
    exit 1
}
[ -x "$BHS" ] || die "there is no program $BHS"
command -v openjd > /dev/null || die 'there is no openjd: pip install openjd-cli'

try=$(mktemp -d)
trap 'rm -rf -- "$try"' EXIT
# A folder with a space, which shells would cut.
mkdir "$try/the scenes" "$try/out"
cd -- "$try"
cat > "the scenes/room.bhs" <<'SCENE'
Define "x" 0
Film "rgb" "integer xresolution" 40 "integer yresolution" 30 "string layers" "variance"
Sampler "sobol" "integer pixelsamples" 12
LookAt $x 1 -4  0 1 0  0 1 0
WorldBegin
BlackHole "schwarzschild" "point3 center" [0 1.5 0] "float rs" 0.1
LightSource "infinite"
Shape "sphere" "float radius" 0.6
SCENE
printf 'frame,x\n1,-1\n7,1\n' > keys.csv

same() {
    cmp -- "$1.png" "$2.png" || die "$1.png and $2.png differ"
    "$BHS" compare "$1.exr" "$2.exr" --json | grep -q '"largest": 0.0' || die "$1.exr and $2.exr differ"
}

"$BHS" render "the scenes/room.bhs" -o alone.exr --quiet
"$BHS" render "the scenes/room.bhs" -o alone_film.exr --frames 1-7 --keys keys.csv --quiet
for template in parts frames; do openjd check "$here/$template.yaml"; done

# As on a worker that sees the folders of the one who submits elsewhere.
rules='{"version": "pathmapping-1.0", "path_mapping_rules": [{"source_path_format": "POSIX", "source_path": "/submitted", "destination_path": "'$try'"}]}'
openjd run "$here/parts.yaml" --step Join --run-dependencies --path-mapping-rules "$rules" \
    -p "Scene=/submitted/the scenes/room.bhs" -p Output=/submitted/out/room.exr -p Parts=5 -p "Program=$BHS" > parts.log 2>&1 ||
    { cat parts.log; die 'the parts have failed'; }
same alone out/room
grep -q 'openjd_progress: 100' parts.log || { cat parts.log; die 'nobody says how far it is'; }

openjd run "$here/frames.yaml" --path-mapping-rules "$rules" -p "Scene=/submitted/the scenes/room.bhs" -p Output=/submitted/out/film.exr \
    -p Frames=1-7 -p ChunkSize=3 -p "Flags=--keys $try/keys.csv" -p "Program=$BHS" > frames.log 2>&1 ||
    { cat frames.log; die 'the frames have failed'; }
for frame in 1 2 3 4 5 6 7; do same "alone_film.000$frame" "out/film.000$frame"; done

# What fails is told.
if openjd run "$here/parts.yaml" --step Render -tp Part=1 -p "Scene=$try/none.bhs" -p "Output=$try/out/none.exr" -p "Program=$BHS" > fails.log 2>&1; then
    die 'a scene that is not there was rendered'
fi
grep -q 'openjd_fail:.*none.bhs' fails.log || { cat fails.log; die 'nobody says what has failed'; }
echo 'all was tried'
