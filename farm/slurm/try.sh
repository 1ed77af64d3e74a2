#!/bin/sh
# Tries the scripts of this folder on a real Slurm of four nodes on this host: renders a picture in parts and a film in frames, kills a node in
# the middle, stops tasks, loses a part, and holds what comes out against what one machine makes. Exit code 0: all of it was tried and is right.
#
#     farm/slurm/try.sh [--no-install] [FOLDER]       FOLDER keeps what was made; without it nothing stays
#
# Slurm comes from Debian's packages (slurmctld, slurmd, slurm-client), installed by apt-get where they are missing. The program is $BHS, or the
# repository's target/release/bhs, or it is built. Every daemon that it starts ends with it. It takes some minutes.
set -eu

here=$(cd -- "$(dirname -- "$0")" && pwd)
root=${here%/farm/slurm}
. "$here/common.sh"
. "$here/cluster.sh"

install=yes
[ "${1-}" != --no-install ] || { install=; shift; }
PATH=$PATH:/usr/sbin:/sbin
export PATH

has_slurm() {
    for tool in slurmctld slurmd sbatch scontrol squeue sinfo scancel; do
        command -v "$tool" > /dev/null || return 1
    done
}

if ! has_slurm; then
    [ -n "$install" ] || die 'Slurm is not installed (slurmctld, slurmd, slurm-client)'
    sudo=
    [ "$(id -u)" -eq 0 ] || sudo=sudo
    $sudo apt-get update
    # Their services are not wanted: where there is systemd, they fail for want of a configuration, and stay down.
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends slurmctld slurmd slurm-client
    has_slurm || die 'apt-get has not installed Slurm'
fi

BHS=${BHS:-$root/target/release/bhs}
[ -x "$BHS" ] || (cd -- "$root" && cargo build --release --bin bhs)
BHS=$(absolute "$BHS")
export BHS

if [ $# -gt 0 ]; then
    mkdir -p -- "$1"
    try=$(absolute "$1")
else
    try=$(mktemp -d)
fi
kept=$#
finish() {
    code=$?
    trap '' EXIT INT TERM
    cluster_stop
    left=$(ps -eo pid=,args= | grep -F "$try" | grep -E '[s]lurm(ctld|d|stepd)' || true)
    [ -z "$left" ] || { echo "these are left: $left"; code=1; }
    [ "$kept" -gt 0 ] || rm -rf -- "$try"
    exit "$code"
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

began=$(date +%s)
step() {
    printf '\n==== %s (%s s)\n' "$*" "$(($(date +%s) - began))"
}

# Waits until a command is content, up to so many seconds.
within() {
    limit=$1
    shift
    until "$@" > /dev/null 2>&1; do
        limit=$((limit - 1))
        [ "$limit" -gt 0 ] || { echo "waited too long for: $*"; squeue; tail -n 4 log/* "$try"/*.farm/log/* 2>/dev/null; return 1; }
        sleep 1
    done
}

# That two pictures are the same to the bit: all channels of the EXR, and the bytes of the PNG.
same() {
    cmp -- "$1.png" "$2.png" || die "$1.png and $2.png differ"
    "$BHS" compare "$1.exr" "$2.exr" --json > compared.json
    grep -q '"largest": 0.0' compared.json || { cat compared.json; die "$1.exr and $2.exr differ"; }
}

# How often each task of a job has begun, and where: lines of number, node.
begun() {
    cat "$1"/log/[0-9]* | sed -n 's/^[0-9-]* [0-9:]* \([0-9]*\) begins on \(.*\)/\1 \2/p'
}

cd -- "$try"
cat > room.bhs <<'SCENE'
Define "x" 0
Film "rgb" "integer xresolution" 160 "integer yresolution" 120 "string layers" ["normal" "variance"]
Sampler "sobol" "integer pixelsamples" 480
LookAt $x 1 -4  0 1 0  0 1 0
Camera "perspective" "float fov" 45
WorldBegin
BlackHole "schwarzschild" "point3 center" [0 1.5 0] "float rs" 0.1
LightSource "infinite" "rgb L" [0.7 0.8 1]
LightSource "stars" "integer number" 300 "float scale" 1e8
Shape "sphere" "float radius" 0.6
AttributeBegin
    Translate 1 1 1.5
    Material "conductor" "float roughness" 0.2
    Shape "sphere" "float radius" 0.6
AttributeEnd
Rotate -90 1 0 0
Shape "disk" "float radius" 3
SCENE
cat > room.csv <<'KEYS'
frame,x
1,-1
24,1
KEYS

step 'one machine: a picture, and a film of 24 frames'
"$BHS" render room.bhs -o alone.exr --quiet
"$BHS" render room.bhs -o film_alone.exr --frames 1-24 --keys room.csv --spp 96 --resolution 80x60 --quiet

step 'a Slurm of four nodes'
cluster_start "$try/slurm"
sinfo -N

step 'a picture in 12 parts; a node dies in the middle'
"$here/submit" room.bhs -o room.exr --parts 12 --cpus 1 --time 10
# Some parts are done, and the node has begun one and not ended it: nothing moves there while that is asked.
node_dies() {
    ls room.farm/done.* > /dev/null || return 1
    cluster_signal_node STOP 2
    lost=$(squeue -h -t running -w bhs2 --array -o %K)
    if is_number "$lost" && grep -q 'begins on bhs2' "room.farm/log/$lost" && [ ! -e "room.farm/done.$((lost + 1))" ]; then
        cluster_kill_node 2
        return 0
    fi
    cluster_signal_node CONT 2
    return 1
}
within 300 node_dies
echo "bhs2 is dead; it was at work on part $((lost + 1))"
"$here/status" room.farm || true
within 600 test -e room.farm/joined
"$here/status" room.farm
same alone room
# Each part was begun once, but for those of the dead node.
for number in $(seq 12); do
    runs=$(begun room.farm | grep -c "^$number ")
    first_node=$(begun room.farm | sed -n "s/^$number //p" | head -n 1)
    [ "$runs" -eq 1 ] || { [ "$runs" -eq 2 ] && [ "$first_node" = bhs2 ] && [ $((number - 1)) -eq "$lost" ]; } ||
        die "part $number was begun $runs times, first on $first_node"
done
[ "$(begun room.farm | wc -l)" -eq 13 ] || die "$(begun room.farm | wc -l) tasks were begun for 12 parts and 1 that was lost"
echo 'what the dead node had begun was done again, and nothing else'

step 'a part is lost: it is named, and rendered again'
rm room.farm/5.bhspart room.png
! "$here/join" "$try/room.farm" > join.out 2>&1 || die 'eleven of twelve parts were joined'
grep -q missing join.out || die "nobody says what is missing: $(cat join.out)"
[ ! -e room.png ] || die 'something was written all the same'
! "$here/status" room.farm || die 'nothing seems to be missing'
"$here/resubmit" room.farm
within 300 test -e room.farm/joined
same alone room
[ "$(begun room.farm | wc -l)" -eq 14 ] || die 'more than the lost part was rendered again'

step 'a film of 24 frames; a task is told to end'
cluster_revive_node 2
# The state of a film that is called alike.
: > film.other.0001.checkpoint
"$here/submit" room.bhs -o film.exr --frames 01-24 --cpus 1 --time 10 -- --keys room.csv --spp 96 --resolution 80x60
film_works() { squeue -h -t running -o %i | grep -q .; }
within 120 film_works
within 300 sh -c "ls film.farm/state.*.checkpoint"
# What runs is not started a second time.
before=$(squeue -h --array -o %i | wc -l)
"$here/resubmit" film.farm
[ "$(squeue -h --array -o %i | wc -l)" -le "$before" ] || die 'tasks that are under way were submitted again'
# It says that the job is changing when it has been put into the queue again by then.
scancel --signal=TERM --batch "$(squeue -h -t running --array -o %i | tail -n 1)" || true
within 900 "$here/status" film.farm
"$here/status" film.farm
for frame in $(seq -w 1 24); do same "film_alone.00$frame" "film.00$frame"; done
[ "$(ls . film.farm | grep checkpoint)" = film.other.0001.checkpoint ] || die 'checkpoints are left, or those of others are gone'
grep -h 'is kept' film.farm/log/* || die 'no task was stopped'

step 'a part that meets its time limit goes on later'
"$BHS" render room.bhs -o long_alone.exr --spp 2700 --resolution 80x60 --quiet &
long=$!
"$here/submit" room.bhs -o long.exr --parts 1 --cpus 1 --time 1 --warn 45 -- --spp 2700 --resolution 80x60
within 300 grep -q 'is kept' long.farm/log/0
# Neither the two minutes that Slurm lets it wait nor so short a limit once more.
task=$(head -n 1 long.farm/jobs)_0
within 60 scontrol update "JobId=$task" TimeLimit=10 StartTime=now
within 900 test -e long.farm/joined
wait "$long"
same long_alone long
echo "it was begun $(begun long.farm | wc -l) times"
[ "$(begun long.farm | wc -l)" -gt 1 ] || die 'it did not meet its limit: the machine is too fast for this trial'

step 'all was tried'
