#!/usr/bin/env bash
# Runs the shards of a study on one machine with several GPUs, one at a time on each, by GNU parallel, and merges them.
#
#   cluster/workstation.sh studies/filler_map.toml
#   SHARDS=64 cluster/workstation.sh studies/filler_map.toml --trials 1000000
#   DEVICES="cpu llvmpipe" cluster/workstation.sh studies/filler_map.toml
#
# Options after the study go to `sagnac run`. Ctrl-C stops after the current batches. A new start samples only what is
# missing. Variables:
#
#   SAGNAC    the program, if it is not in PATH
#   DEVICES   one value of `sagnac run --device` per slot (default: the PCI addresses of all GPUs)
#   SHARDS    number of shards (default: 8 per device, so that a slow device does not delay the end for long)
#   RESULTS   folder of the shards (default: results/NAME-OF-THE-STUDY)
set -euo pipefail

study=${1:?usage: cluster/workstation.sh STUDY [options of sagnac run]}
shift
export SAGNAC=${SAGNAC:-sagnac}
read -r -a devices <<<"${DEVICES:-$("$SAGNAC" devices | sed -n 's/.*, PCI //p' | tr '\n' ' ')}"
if ((${#devices[@]} == 0)); then
  echo "error: no GPU with a PCI address was found: name the devices, DEVICES=\"cpu\"; \`sagnac device list\` lists them" >&2
  exit 2
fi
shards=${SHARDS:-$((8 * ${#devices[@]}))}
name=${study##*/}
results=${RESULTS:-results/${name%.toml}}
threads=$(($(nproc) / ${#devices[@]}))
mkdir -p "$results"

# Arguments: number of the shard and of the slot. Shards that run at the same time have different slots.
run_shard() {
  local shard=$1 slot=$2 devices
  shift 2
  read -r -a devices <<<"$DEVICES"
  local out=$RESULTS/shard-$shard-of-$SHARDS code=0
  "$SAGNAC" run "$STUDY" --shard "$shard/$SHARDS" --out "$out" --device "${devices[slot - 1]}" --threads "$THREADS" \
    "$@" || code=$?
  # A shard that a --time-limit stopped has not failed; the merge says what is missing.
  ((code != 4)) || code=0
  return "$code"
}
export -f run_shard
export STUDY=$study DEVICES="${devices[*]}" SHARDS=$shards RESULTS=$results THREADS=$((threads > 1 ? threads : 1))

# --resume is not used: parallel would skip the shards in its log even if --trials was raised, and sagnac itself knows
# what is missing. Parallel sends one TERM and then waits, because a second TERM would stop sagnac before it has written.
seq "$shards" | parallel --jobs "${#devices[@]}" --retries 3 --halt soon,fail=3 --termseq TERM,10000,KILL,25 \
  --joblog "$results/shards.log" --tag --line-buffer run_shard '{}' '{%}' "${@@Q}"

"$SAGNAC" merge "$results"/shard-*-of-"$shards" --out "$results"
