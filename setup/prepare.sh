# Sourced by ./bhs and ./test, which set $root to this checkout: installs what is missing. When nothing is, this only looks
# at a few files, which takes some milliseconds.

# Says what is missing and how to get it, and gives up.
die() {
    { printf 'bhs set-up: ' && printf '%s\n' "$@"; } >&2
    exit 1
}

# Runs one of the set-up's Python scripts.
setup_python() {
    command -v python3 >/dev/null || die "python3 is missing; the set-up needs it once." \
        "    Debian, Ubuntu: apt install python3 python3-pip      Fedora: dnf install python3-pip      Arch: pacman -S python-pip"
    python3 "$@" || exit $?
}

# Embree, libclang, Cargo's configuration: what .deps/stamp lists exists, for this folder, and no set-up file is newer.
tools_ready() {
    stamp=$root/.deps/stamp
    [ -f "$stamp" ] || return 1
    for file in "$root"/setup/*.*; do
        [ "$stamp" -nt "$file" ] || return 1
    done
    {
        read -r line && [ "$line" = "$root" ] || return 1
        while read -r line; do
            [ -e "$line" ] || return 1
        done
    } <"$stamp"
}

prepare_tools() {
    command -v cargo >/dev/null || PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
    command -v cargo >/dev/null || die "cargo is missing; install Rust with rustup (see rust-lang.org), or" \
        "    Debian, Ubuntu: apt install rustup      Fedora: dnf install rustup      Arch: pacman -S rustup"
    tools_ready || setup_python "$root/setup/setup.py"
}

# In $root: the crates that Cargo.lock lists, from Cargo's cache if they are there.
prepare_crates() {
    host=$(rustc -vV | sed -n 's/^host: //p')
    cargo fetch --offline --quiet --target "$host" 2>/dev/null || cargo fetch --target "$host" ||
        die "crates that bhs is built from are missing, and cargo could not download them (see above)." \
            "    Connect this machine to the network and start again, or copy the folder ${CARGO_HOME:-$HOME/.cargo}/registry from a" \
            "    machine with network, after cargo fetch in a copy of this folder."
}

# The arguments are --all, or a command line of bhs: fetches the meshes that its scenes name.
prepare_meshes() {
    missing=$(
        while read -r name _; do
            case $name in '' | \#*) continue ;; esac
            [ -f "$root/scenes/meshes/$name" ] || echo "$name"
        done <"$root/setup/meshes.txt"
    )
    [ -n "$missing" ] || return 0
    wanted=
    for argument; do
        case $argument in
        --all) wanted=yes ;;
        *.bhs | *.pbrt) if sed "s/#.*//" "$argument" 2>/dev/null | grep -qF -e "$missing" -e Include; then wanted=yes; fi ;;
        esac
    done
    [ -z "$wanted" ] || setup_python "$root/setup/meshes.py" "$@"
}

# The arguments are --if-there-is-one, or a command line of bhs: fetches Open Image Denoise if they denoise a picture.
prepare_denoiser() {
    version=$(sed -n 's/^pyoidn==\([0-9.]*\).*/\1/p' "$root/setup/oidn.txt")
    [ ! -d "$root/.deps/oidn-$version" ] || return 0
    wanted=
    for argument; do
        case $argument in
        denoise | --denoise | --if-there-is-one) wanted=yes ;;
        # Who only asks what there is waits for nothing.
        -h | --help) return 0 ;;
        esac
    done
    [ -z "$wanted" ] || setup_python "$root/setup/oidn.py" "$@"
}
