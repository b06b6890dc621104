#!/bin/sh
# The robustness study and its curves: runs pipelines/robustness.toml and puts every study's curves, as SVG and as CSV,
# into docs/robustness/.
#   sh benches/robustness.sh [PROGRAM [OPTIONS OF `rootvox run` ...]]
set -e
cd "$(dirname "$0")/.."
rootvox=${1:-target/release/rootvox}
[ $# -gt 0 ] && shift
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
for study in pipelines/robustness.toml pipelines/robustness-cameras.toml; do
    "$rootvox" run "$study" --results "$results" "$@"
done
mkdir -p docs/robustness
for folder in "$results"/robustness-*; do
    name=$(basename "$folder" | sed 's/^robustness-//')
    cp "$folder/curves.svg" "docs/robustness/$name.svg"
    cp "$folder/curves.csv" "docs/robustness/$name.csv"
done
