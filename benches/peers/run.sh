#!/usr/bin/env bash
# Times Takt's fastest motion and what free programs make of the same waypoints in turn, on one core.
# Packages go into a virtual environment of their own, outside this tree.
set -euo pipefail
cd "$(dirname "$0")/../.."

environment=$(mktemp -d)
trap 'rm -rf "$environment"' EXIT
python3 -m venv "$environment"
"$environment/bin/pip" install --quiet -r benches/peers/requirements.txt
cargo bench --no-run --bench jerk_limited
for round in 1 2; do
    echo "round $round: the peers"
    taskset -c 0 "$environment/bin/python" benches/peers/fastest.py
    echo "round $round: Takt, with its lower bound"
    RAYON_NUM_THREADS=1 taskset -c 0 cargo bench --bench jerk_limited
done
