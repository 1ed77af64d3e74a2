# What the scripts share; sourced.

die() {
    printf 'error: %s\n' "$*" >&2
    exit 1
}

is_number() {
    case $1 in '' | *[!0-9]*) return 1 ;; esac
}

# A number as shells compute with it: with leading zeros it would be octal.
decimal() {
    printf '%s' "$1" | sed 's/^0*\([0-9]\)/\1/'
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

# Those of the files that are there.
that_are_there() {
    for file in "$@"; do
        [ ! -e "$file" ] || printf '%s\n' "$file"
    done
}

# What task $1 has made: its picture or part, of all cameras.
results() {
    if [ -n "$parts" ]; then
        that_are_there "$work/$1.bhspart" "$work/$1".*.bhspart
    else
        digits=$(printf '%04d' "$1")
        that_are_there "${output%.exr}.$digits.exr" "${output%.exr}".*."$digits.exr"
    fi
}

# What task $1 goes on from: its checkpoints and those before them, of all cameras. They lie in the folder of the job, where all is its own.
states() {
    that_are_there "$work/state.$1.checkpoint" "$work/state.$1".*.checkpoint
}

# Slurm's jobs of this one, separated by commas; nothing if there are none.
job_ids() {
    [ ! -s "$work/jobs" ] || paste -s -d , "$work/jobs"
}

# Whether task $1 is done: that has a mark, for a frame that was stopped has a picture too; and what it has made is still there.
is_done() {
    [ -e "$work/done.$1" ] && [ -n "$(results "$1")" ]
}
