"""First paths of OMPL's planners on the maps of the bench, from Python.

OMPL searches in C++, but asks Python whether a state is free, and that takes
nearly all of the time. So beside the whole time stands what is left when the
checker's own is taken away; binding calls are still in it. Times of OMPL called
from C++ stand in the maps' file, and the bench prints them beside Takt's.
"""

import json
import os
import statistics
import time

from ompl import base, geometric, util

util.setLogLevel(util.LOG_NONE)
DATA = os.environ.get("TAKT_BENCH_DATA", "../shared/bench")
RUNS = 31


class Checker:
    def __init__(self, obstacles):
        self.balls = [(*ball["center"], ball["radius"] ** 2) for ball in obstacles]
        self.seconds = 0.0

    def __call__(self, state):
        begun = time.perf_counter()
        x, y = state[0], state[1]
        free = all((x - a) ** 2 + (y - b) ** 2 > r for a, b, r in self.balls)
        self.seconds += time.perf_counter() - begun
        return free


def run(map, planner, limit):
    space = base.RealVectorStateSpace(2)
    bounds = base.RealVectorBounds(2)
    bounds.setLow(map["lower"][0])
    bounds.setHigh(map["upper"][0])
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    checker = Checker(map["obstacles"])
    setup.setStateValidityChecker(checker)
    setup.getSpaceInformation().setStateValidityCheckingResolution(0.002)
    start, goal = space.allocState(), space.allocState()
    for state, values in (start, map["start"]), (goal, map["goal"]):
        state[0], state[1] = values
    setup.setStartAndGoalStates(start, goal)
    setup.setPlanner(planner(setup.getSpaceInformation()))
    setup.setup()
    checker.seconds = 0.0
    begun = time.perf_counter()
    setup.solve(limit)
    seconds = time.perf_counter() - begun
    return seconds, seconds - checker.seconds, setup.getSolutionPath().length()


with open(os.path.join(DATA, "maps2d.json")) as file:
    maps = json.load(file)["maps"]
for map in maps:
    for name, limit in ("RRTConnect", 5.0), ("RRT", 5.0):
        runs = [run(map, getattr(geometric, name), limit) for _ in range(RUNS)]
        whole, own, length = (statistics.median(column) for column in zip(*runs))
        print(
            f"{map['name']:13} {name:15} first path {whole * 1e6:8.1f} us, "
            f"without the checker {own * 1e6:8.1f} us, length {length:.2f}"
        )
    runs = [run(map, geometric.InformedRRTstar, 1.0)[2] for _ in range(3)]
    print(f"{map['name']:13} InformedRRTstar length after 1 s {statistics.median(runs):.3f}")
