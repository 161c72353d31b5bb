#!/usr/bin/env bash
# Times Takt's swarm and those of pyswarms and pygmo in turn, on one core.
# Packages go into a virtual environment of their own, outside this tree.
set -euo pipefail
cd "$(dirname "$0")/../.."

environment=$(mktemp -d)
trap 'rm -rf "$environment"' EXIT
python3 -m venv "$environment"
"$environment/bin/pip" install --quiet -r benches/peers/requirements.txt
cargo bench --no-run --bench swarm
for round in 1 2; do
    echo "round $round: the peers"
    taskset -c 0 "$environment/bin/python" benches/peers/swarm.py
    echo "round $round: Takt (thrpt: evaluations per second)"
    RAYON_NUM_THREADS=1 taskset -c 0 cargo bench --bench swarm -- pso
done
