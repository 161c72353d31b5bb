"""Writes state_to_state.json: random problems between two states and the durations that
Ruckig (community version, `pip install ruckig==0.19.4`, MIT licence) gives for them.

A state is [position, velocity, acceleration], limits are [velocity, acceleration, jerk], `null` is
no limit. `own` is the least duration of each joint alone. Kinds: `rest`, `moving`, `waiting` (no joint's
own least duration is possible for all), `jerk-free` and `acceleration-free`.
"""

import json
import random

import ruckig

FREE = float("inf")


def moving(draw, velocity, acceleration, jerk):
    while True:
        v, a = round(draw.uniform(-velocity, velocity), 4), round(draw.uniform(-acceleration, acceleration), 4)
        if draw.random() < 0.2:
            a = 0.0
        if abs(v) + a * a / (2 * jerk) < velocity:
            return v, a


def joint(draw, kind):
    velocity, acceleration, jerk = (round(draw.uniform(*r), 3) for r in [(0.5, 3), (1, 15), (5, 100)])
    v0 = a0 = v1 = a1 = 0.0
    if kind != "rest":
        v0, a0 = moving(draw, velocity, acceleration, jerk)
        v1, a1 = moving(draw, velocity, acceleration, jerk)
    if kind == "jerk-free":
        jerk, a0, a1 = FREE, 0.0, 0.0
    if kind == "acceleration-free":
        acceleration = FREE
    x0, x1 = round(draw.uniform(-3, 3), 4), round(draw.uniform(-3, 3), 4)
    if kind == "waiting":
        x1 = round(x0 + draw.gauss(0, 0.3), 4)
    return [x0, v0, a0], [x1, v1, a1], [velocity, acceleration, jerk]


def solved(start, goal, limits):
    count = len(start)
    given, found = ruckig.InputParameter(count), ruckig.Trajectory(count)
    given.current_position, given.current_velocity, given.current_acceleration = zip(*start)
    given.target_position, given.target_velocity, given.target_acceleration = zip(*goal)
    given.max_velocity, given.max_acceleration, given.max_jerk = zip(*limits)
    assert ruckig.Ruckig(count).calculate(given, found) == ruckig.Result.Working
    return found.duration, list(found.independent_min_durations)


draw = random.Random(2105)
problems = []
for kind, count in [("rest", 12), ("moving", 16), ("waiting", 16), ("jerk-free", 8), ("acceleration-free", 8)]:
    while count:
        start, goal, limits = zip(*(joint(draw, kind) for _ in range(draw.randint(2 if kind == "waiting" else 1, 6))))
        duration, own = solved(start, goal, limits)
        if kind == "waiting" and duration < 1.0001 * max(own):
            continue
        limits = [[None if value == FREE else value for value in row] for row in limits]
        problems.append(dict(kind=kind, start=start, goal=goal, limits=limits, duration=duration, own=own))
        count -= 1
with open("state_to_state.json", "w") as file:
    file.write("[\n" + ",\n".join(json.dumps(problem) for problem in problems) + "\n]\n")
