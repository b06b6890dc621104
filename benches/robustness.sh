#!/bin/sh
# The robustness studies and their curves: runs pipelines/robustness.toml, pipelines/dense.toml and, where COLMAP is installed,
# pipelines/robustness-cameras.toml, and puts every study's curves, as SVG and as CSV, into docs/robustness/.
#   sh benches/robustness.sh [PROGRAM [OPTIONS OF `rootvox run` ...]]
set -e
cd "$(dirname "$0")/.."
rootvox=${1:-target/release/rootvox}
[ $# -gt 0 ] && shift
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
mkdir -p docs/robustness
for study in robustness dense robustness-cameras; do
    [ $study != robustness-cameras ] || command -v colmap > /dev/null || break
    "$rootvox" run "pipelines/$study.toml" --results "$results" "$@"
    for folder in "$results"/robustness-*; do
        name=$(basename "$folder" | sed 's/^robustness-//')
        cp "$folder/curves.svg" "docs/robustness/$name.svg"
        cp "$folder/curves.csv" "docs/robustness/$name.csv"
    done
done
