"""Microseconds per motion of six joints between two states with Ruckig, whose Python
binding calls C++ once per motion: random problems as in benches/state_to_state.rs."""

import random
import time

import ruckig

JOINTS, PROBLEMS, ROUNDS = 6, 2000, 20


def state(draw, velocity, acceleration, jerk, moving):
    while moving:
        v, a = draw.uniform(-velocity, velocity), draw.uniform(-acceleration, acceleration)
        if abs(v) + a * a / (2 * jerk) <= velocity:
            return draw.uniform(-3, 3), v, a
    return draw.uniform(-3, 3), 0.0, 0.0


def problem(draw, moving):
    limits = [(draw.uniform(0.5, 3), draw.uniform(1, 15), draw.uniform(5, 100)) for _ in range(JOINTS)]
    ends = [[state(draw, *row, moving) for row in limits] for _ in range(2)]
    given = ruckig.InputParameter(JOINTS)
    given.current_position, given.current_velocity, given.current_acceleration = zip(*ends[0])
    given.target_position, given.target_velocity, given.target_acceleration = zip(*ends[1])
    given.max_velocity, given.max_acceleration, given.max_jerk = zip(*limits)
    return given


for name, moving in [("at rest", False), ("moving", True)]:
    draw = random.Random(21)
    problems = [problem(draw, moving) for _ in range(PROBLEMS)]
    generator, found = ruckig.Ruckig(JOINTS), ruckig.Trajectory(JOINTS)
    best = float("inf")
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for given in problems:
            generator.calculate(given, found)
        best = min(best, time.perf_counter() - start)
    print(f"ruckig {name}: {best / PROBLEMS * 1e6:.2f} us")
