# A Slurm of four nodes on this host, for trying: sourced by try.sh. No systemd, no cgroups, no munge: everybody on this host could use it, so it
# listens on the loopback interface alone and ends with the script.
#
#     cluster_start FOLDER        starts slurmctld and the nodes bhs1 to bhs4, whose files lie in FOLDER
#     cluster_signal_node S N     sends a signal to node N and all that it runs
#     cluster_kill_node N         kills node N and all that it runs, as a power failure would
#     cluster_revive_node N
#     cluster_stop                ends every process that it has started

cluster_nodes='1 2 3 4'

cluster_start() {
    cluster=$1
    mkdir -p "$cluster/state" "$cluster/log"
    # Ports that others on this host do not have.
    base=$((20000 + $$ % 20000 / 10 * 10))
    cat > "$cluster/slurm.conf" <<CONF
ClusterName=bhs
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=$base
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/none
CredType=cred/none
CommunicationParameters=NoAddrCache,NoCtldInAddrAny,NoInAddrAny
StateSaveLocation=$cluster/state
SlurmctldPidFile=$cluster/slurmctld.pid
SlurmctldLogFile=$cluster/log/slurmctld
SlurmdSpoolDir=$cluster/spool.%n
SlurmdPidFile=$cluster/slurmd.%n.pid
SlurmdLogFile=$cluster/log/slurmd.%n
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/filetxt
JobCompLoc=$cluster/log/jobs
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
SlurmctldTimeout=20
SlurmdTimeout=10
InactiveLimit=0
KillWait=20
MinJobAge=3600
UnkillableStepTimeout=30
SchedulerParameters=batch_sched_delay=0,sched_min_interval=500000,sched_interval=5,bf_interval=5,requeue_delay=1
NodeName=bhs[1-4] NodeHostname=localhost NodeAddr=127.0.0.1 Port=$((base + 1)),$((base + 2)),$((base + 3)),$((base + 4)) CPUs=1 RealMemory=1000 State=UNKNOWN
PartitionName=all Nodes=bhs[1-4] Default=YES MaxTime=INFINITE State=UP
CONF
    export SLURM_CONF=$cluster/slurm.conf
    slurmctld -D -f "$SLURM_CONF" > "$cluster/log/slurmctld.out" 2>&1 &
    cluster_ctld=$!
    for n in $cluster_nodes; do cluster_revive_node "$n"; done
    tries=0
    until [ "$(sinfo -h -N -t idle -o %N 2>/dev/null | wc -l)" -eq 4 ]; do
        tries=$((tries + 1))
        [ "$tries" -lt 60 ] || { echo "the nodes do not come up:" >&2; tail -n 5 "$cluster"/log/* >&2; return 1; }
        sleep 1
    done
}

cluster_revive_node() {
    mkdir -p "$cluster/spool.bhs$1"
    slurmd -D -N "bhs$1" -f "$SLURM_CONF" > "$cluster/log/slurmd.bhs$1.out" 2>&1 &
    echo $! > "$cluster/node$1"
}

# The processes that have another for an ancestor, itself last.
cluster_family() {
    for child in $(ps -o pid= --ppid "$1"); do cluster_family "$child"; done
    echo "$1"
}

# What runs on a node: the environment of a job's processes tells.
cluster_of_node() {
    for process in /proc/[0-9]*; do
        if grep -zsqFx "SLURM_CONF=$SLURM_CONF" "$process/environ" && grep -zsqFx "SLURMD_NODENAME=bhs$1" "$process/environ"; then
            echo "${process#/proc/}"
        fi
    done
}

# Sends a signal to node N and all that it runs.
cluster_signal_node() {
    all="$(cluster_family "$(cat "$cluster/node$2")") $(cluster_of_node "$2")"
    for id in $all; do
        # The step's daemon is the parent of what it runs.
        parent=$(ps -o ppid= -p "$id" 2>/dev/null | tr -d ' ')
        case $(ps -o comm= -p "${parent:-0}" 2>/dev/null) in slurmstepd*) all="$parent $all" ;; esac
    done
    # shellcheck disable=SC2086
    kill "-$1" $all 2>/dev/null || true
}

cluster_kill_node() {
    cluster_signal_node KILL "$1"
    wait "$(cat "$cluster/node$1")" 2>/dev/null || true
}

cluster_stop() {
    [ -n "${cluster_ctld-}" ] || return 0
    scancel --quiet --user="$(id -un)" 2>/dev/null || true
    for n in $cluster_nodes; do
        kill "$(cat "$cluster/node$n")" 2>/dev/null || true
    done
    kill "$cluster_ctld" 2>/dev/null || true
    sleep 1
    for n in $cluster_nodes; do cluster_kill_node "$n"; done
    kill -KILL "$cluster_ctld" 2>/dev/null || true
    wait "$cluster_ctld" 2>/dev/null || true
    cluster_ctld=
}
