# What the scripts share; sourced.

die() {
    printf 'error: %s\n' "$*" >&2
    exit 1
}

is_number() {
    case $1 in '' | *[!0-9]*) return 1 ;; esac
}

# A word as a shell reads it back.
quoted() {
    printf "'%s'" "$(printf '%s' "$1" | sed "s/'/'\\\\''/g")"
}

absolute() {
    case $1 in /*) printf '%s' "$1" ;; *) printf '%s/%s' "$(pwd)" "$1" ;; esac
}

# The folder of a job, in $work.
find_job() {
    work=$(absolute "${1%/}")
    [ -f "$work/job" ] || die "there is no job in \`$1\`: \`submit\` makes one"
}

# The numbers of all tasks: parts, or frames.
numbers() {
    seq "$first" "$step" "$last"
}

# Files of frame $1 with the ending $2, of all cameras, and whether there is one.
of_frame() {
    digits=$(printf '%04d' "$1")
    for file in "${output%.exr}.$digits.$2" "${output%.exr}".*."$digits.$2"; do
        [ ! -e "$file" ] || printf '%s\n' "$file"
    done
}

# Files of part $1 with the ending $2, of all cameras.
of_part() {
    for file in "$work/$1.$2" "$work/$1".*."$2"; do
        [ ! -e "$file" ] || printf '%s\n' "$file"
    done
}

# Files of task $1: its picture or part with $2 `result`, its state with $2 `checkpoint`.
of_task() {
    case ${parts:+part}:$2 in
        part:result) of_part "$1" bhspart ;;
        :result) of_frame "$1" exr ;;
        part:*) of_part "$1" "$2" ;;
        *) of_frame "$1" "$2" ;;
    esac
}

# Whether task $1 is done: that has a mark, for a frame that was stopped has a picture too; and what it has made is still there.
is_done() {
    [ -e "$work/done.$1" ] && [ -n "$(of_task "$1" result)" ]
}
