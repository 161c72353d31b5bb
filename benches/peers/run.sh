#!/usr/bin/env bash
# Times Takt and its peers in turn, on one core: run.sh swarm, run.sh jerk_limited, run.sh state_to_state or run.sh planners,
# with a filter for the bench if wanted (run.sh swarm pso).
# Packages go into a virtual environment of their own, outside this tree.
set -euo pipefail
cd "$(dirname "$0")/../.."
bench=${1:?which bench: swarm, jerk_limited, state_to_state or planners}

environment=$(mktemp -d)
trap 'rm -rf "$environment"' EXIT
python3 -m venv "$environment"
"$environment/bin/pip" install --quiet -r benches/peers/requirements.txt
cargo bench --no-run --bench "$bench"
for round in 1 2; do
    echo "round $round: the peers"
    taskset -c 0 "$environment/bin/python" "benches/peers/$bench.py"
    echo "round $round: Takt"
    RAYON_NUM_THREADS=1 taskset -c 0 cargo bench --bench "$bench" -- "${2-}"
done
