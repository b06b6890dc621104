#!/usr/bin/env bash
# Speed-up of two one-core workers over one on six small plants, each into an empty store. The machine should be quiet.
#   benches/workers.sh [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")/.."
rootvox=$(realpath "${1:-target/release/rootvox}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
uptime
for workers in 1 2 1 2; do
    rm -rf "$work/cache"
    begin=$(date +%s.%N)
    for _ in $(seq "$workers"); do
        "$rootvox" work tests/data/plants.toml --cores 1 --cache "$work/cache" 2> /dev/null &
    done
    wait
    end=$(date +%s.%N)
    echo "$workers workers: $(awk "BEGIN { print $end - $begin }") s"
done
