# A Slurm with two nodes of one CPU and one made-up GPU each, on this machine's loopback: no systemd, own folder, key and
# ports, nothing of /etc/slurm. To be sourced by a script that has `say` and `await`.

slurm=${slurm:?the folder of it all}

# Installs what is missing, as root or through sudo. Packages must not start services here: without systemd that may
# fail, and it is other daemons that are wanted.
slurm_install() {
  local missing=() root=() policy=/usr/sbin/policy-rc.d own='' failed=''
  command -v munged >/dev/null || missing+=(munge)
  command -v slurmctld >/dev/null && command -v slurmd >/dev/null && command -v sbatch >/dev/null || missing+=(slurm-wlm)
  command -v sqlite3 >/dev/null || missing+=(sqlite3)
  ((${#missing[@]})) || return 0
  say "installing ${missing[*]}"
  [[ $(id -u) -eq 0 ]] || root=(sudo)
  if [[ ! -e $policy ]]; then
    own=yes
    printf '#!/bin/sh\nexit 101\n' | "${root[@]}" tee "$policy" >/dev/null
    "${root[@]}" chmod +x "$policy"
  fi
  if ! { "${root[@]}" apt-get update -qq &&
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -qq --no-install-recommends "${missing[@]}"; } >"$slurm/apt.log" 2>&1; then
    cat "$slurm/apt.log" >&2
    failed=yes
  fi
  [[ -z $own ]] || "${root[@]}" rm "$policy"
  [[ -z $failed ]]
}

# Starts one daemon in the foreground of a background job; its process id goes to "$slurm/$1.pid".
daemon() {
  local name=$1
  shift
  "$@" >"$slurm/$name.out" 2>&1 &
  echo $! >"$slurm/$name.pid"
  # The shell need not tell of its end.
  disown $!
}

free_port() {
  local port
  while port=$((20000 + RANDOM % 10000)); do
    (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || break
  done
  echo "$port"
}

start_node() {
  daemon "$1" slurmd -D -f "$slurm/slurm.conf" -N "$1"
}

slurm_start() {
  local user
  user=$(id -un)
  export SLURM_CONF=$slurm/slurm.conf
  mkdir -p "$slurm"/{state,near,far}
  head -c 1024 /dev/urandom >"$slurm/munge.key"
  chmod 600 "$slurm/munge.key"
  cat >"$slurm/slurm.conf" <<CONF
ClusterName=loopback
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
CredType=cred/munge
# A requeued task waits until its old credential has expired: 2 minutes, were this not set.
AuthInfo=socket=$slurm/munge.socket,cred_expire=5
StateSaveLocation=$slurm/state
SlurmdSpoolDir=$slurm/%n
SlurmctldPidFile=$slurm/state/slurmctld.pid
SlurmdPidFile=$slurm/%n/slurmd.pid
SlurmctldLogFile=$slurm/slurmctld.log
SlurmdLogFile=$slurm/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=2,bf_interval=2
GresTypes=gpu
SlurmdTimeout=10
KillWait=10
ReturnToService=2
NodeName=near NodeAddr=127.0.0.1 NodeHostname=$(hostname) Port=$(free_port) CPUs=1 Gres=gpu:1
NodeName=far NodeAddr=127.0.0.1 NodeHostname=$(hostname) Port=$(free_port) CPUs=1 Gres=gpu:1
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  cat >"$slurm/gres.conf" <<CONF
# A GPU must be a device file; nothing here opens it.
NodeName=near,far Name=gpu File=/dev/null
CONF
  # No control groups: what the machine has of them, or not, is no matter here. Slurm 22 cannot be told so, but it does not
  # touch those of version 1 as long as nothing above asks for them.
  case $(slurmd -V) in
  *" 2"[0-2].*) echo "CgroupPlugin=cgroup/v1" ;;
  *) echo "CgroupPlugin=disabled" ;;
  esac >"$slurm/cgroup.conf"
  daemon munged munged --foreground --force --socket="$slurm/munge.socket" --key-file="$slurm/munge.key" \
    --pid-file="$slurm/state/munged.pid" --seed-file="$slurm/state/munged.seed" --log-file="$slurm/munged.log"
  await 10 "munged" test -S "$slurm/munge.socket"
  daemon slurmctld slurmctld -D -f "$slurm/slurm.conf"
  start_node near
  start_node far
  await 30 "two idle nodes" slurm_is_ready
}

slurm_is_ready() {
  [[ $(sinfo --noheader --format='%t %D' 2>/dev/null) == "idle 2" ]]
}

# Processes of our Slurm: each has the path of its configuration in its environment or its arguments.
slurm_processes() {
  local process
  for process in /proc/[0-9]*; do
    [[ ${process#/proc/} != "$$" && ${process#/proc/} != "$BASHPID" ]] || continue
    if grep -qsF "$slurm/" "$process/environ" "$process/cmdline"; then
      echo "${process#/proc/}"
    fi
  done
}

# Ends all of it, on whatever path the test ends; what waits for a controller that is gone does not heed TERM.
slurm_stop() {
  local signal pids
  timeout 5 scancel --quiet --user="$(id -un)" 2>/dev/null || true
  for signal in TERM KILL; do
    for _ in {1..15}; do
      mapfile -t pids < <(slurm_processes)
      ((${#pids[@]})) || return 0
      kill -"$signal" "${pids[@]}" 2>/dev/null || true
      sleep 0.2
    done
  done
}
