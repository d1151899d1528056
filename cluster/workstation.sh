#!/usr/bin/env bash
# The shards of a study on one machine with several GPUs, one at a time on each, by GNU parallel; then their merge.
#
#   cluster/workstation.sh studies/filler_map.toml
#   SHARDS=64 cluster/workstation.sh studies/filler_map.toml --trials 1000000
#   DEVICES="cpu llvmpipe" cluster/workstation.sh studies/filler_map.toml
#
# Options behind the study go to `sagnac run`. Ctrl-C stops after the batches that run; start it again and only what is
# missing is sampled. Variables:
#
#   SAGNAC    the program, where it is not in PATH
#   DEVICES   what `sagnac run --device` is told, one for each slot, instead of all GPUs by their PCI addresses
#   SHARDS    how many shards, 8 for each device, so that a slow one is not long the last
#   RESULTS   where they go, instead of results/NAME-OF-THE-STUDY
set -euo pipefail

study=${1:?usage: cluster/workstation.sh STUDY [options of sagnac run]}
shift
export SAGNAC=${SAGNAC:-sagnac}
read -r -a devices <<<"${DEVICES:-$("$SAGNAC" devices | sed -n 's/.*, PCI //p' | tr '\n' ' ')}"
if ((${#devices[@]} == 0)); then
  echo "error: no GPU with a PCI address was found: name the devices, DEVICES=\"cpu\"; \`sagnac devices\` lists them" >&2
  exit 2
fi
shards=${SHARDS:-$((8 * ${#devices[@]}))}
name=${study##*/}
results=${RESULTS:-results/${name%.toml}}
threads=$(($(nproc) / ${#devices[@]}))
mkdir -p "$results"

# The first argument is the number of the shard, the second that of the slot: no two that run have the same.
run_shard() {
  local shard=$1 slot=$2 devices
  shift 2
  read -r -a devices <<<"$DEVICES"
  local out=$RESULTS/shard-$shard-of-$SHARDS code=0
  "$SAGNAC" run "$STUDY" --shard "$shard/$SHARDS" --out "$out" --device "${devices[slot - 1]}" --threads "$THREADS" \
    "$@" || code=$?
  # One that a --time-limit stopped has not failed; the merge says what is missing.
  ((code != 4)) || code=0
  return "$code"
}
export -f run_shard
export STUDY=$study DEVICES="${devices[*]}" SHARDS=$shards RESULTS=$results THREADS=$((threads > 1 ? threads : 1))

# No --resume: parallel would go by the numbers of its log and not see that --trials were raised; sagnac itself knows
# what is missing. One TERM and time to end, as a second one would not let sagnac write what it has.
seq "$shards" | parallel --jobs "${#devices[@]}" --retries 3 --halt soon,fail=3 --termseq TERM,10000,KILL,25 \
  --joblog "$results/shards.log" --tag --line-buffer run_shard '{}' '{%}' "${@@Q}"

"$SAGNAC" merge "$results"/shard-*-of-"$shards" --out "$results"
