"""What free programs make of the same waypoints: duration in s, time per plan in ms.

- TOPP-RA: the fastest motion along a cubic spline through the waypoints, within
  velocity and acceleration (it knows no jerk limit). The spline's parameter is
  the length of the chords, which it is used with as a rule.
- casadi and IPOPT: segment durations of a quintic spline of class C4, at rest at both ends,
  all limits at 20 points per segment.
- Ruckig: stops at every waypoint, all limits.

Problems: those of the scenarios mcb-ab and wood with the limits of benches/jerk_limited.rs, and the ten of
tests/data/random_problems.json. Run in the folder above benches/.
"""

import json
import statistics
import time

import casadi
import numpy as np
import ruckig
import toppra
import toppra.algorithm
import toppra.constraint

toppra.setup_logging("ERROR")


def problems():
    limits = {
        "mcb-ab": ([0.9, 0.9, 0.9, 0.9, 0.95, 1.0], [0.9, 0.9, 0.9, 0.9, 0.9, 1.0], [2.0] * 6),
        "wood": ([0.6, 0.6, 1.8, 1.8], [0.8, 0.8, 2.4, 2.4], [3.2, 3.2, 9.6, 9.6]),
    }
    for name, rows in limits.items():
        with open(f"scenarios/{name}.json") as file:
            request = json.load(file)
        task = request.get("request", request)["task"]
        yield (name, np.array(task["waypoints"]), *map(np.array, rows))
    with open("tests/data/random_problems.json") as file:
        for p in json.load(file):
            yield (p["name"], *(np.array(p[k]) for k in ("waypoints", "velocity", "acceleration", "jerk")))


def timed(plan, rounds):
    """The median of several runs, after one that does not count."""
    duration = plan()
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        plan()
        times.append(time.perf_counter() - start)
    return duration, 1e3 * statistics.median(times)


def with_toppra(waypoints, velocity, acceleration, _jerk):
    chords = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
    path = toppra.SplineInterpolator(np.r_[0.0, np.cumsum(chords)], waypoints, bc_type="clamped")
    limits = [
        toppra.constraint.JointVelocityConstraint(np.c_[-velocity, velocity]),
        toppra.constraint.JointAccelerationConstraint(np.c_[-acceleration, acceleration]),
    ]
    instance = toppra.algorithm.TOPPRA(limits, path, parametrizer="ParametrizeConstAccel")

    def plan():
        trajectory = instance.compute_trajectory()
        return float(trajectory.duration) if trajectory is not None else float("nan")

    return plan


def quintic_programme(waypoints, velocity, acceleration, jerk):
    """An IPOPT solver of the durations and waypoint states, and its arguments."""
    count, joints = waypoints.shape
    segments = count - 1
    h = casadi.SX.sym("h", segments)
    inner = casadi.SX.sym("inner", (count - 2) * joints * 2)
    states = casadi.reshape(inner, 2, (count - 2) * joints)
    constraints = []

    def state(waypoint, joint):
        if waypoint in (0, count - 1):
            return 0.0, 0.0
        column = (waypoint - 1) * joints + joint
        return states[0, column], states[1, column]

    for joint in range(joints):
        before = None
        for s in range(segments):
            (v0, a0), (v1, a1) = state(s, joint), state(s + 1, joint)
            d, t = waypoints[s + 1, joint] - waypoints[s, joint], h[s]
            c2 = 0.5 * a0 * t**2
            c1 = v0 * t
            e0, e1, e2 = d - c1 - c2, v1 * t - c1 - 2 * c2, a1 * t**2 - 2 * c2
            c3, c4, c5 = 10 * e0 - 4 * e1 + e2 / 2, -15 * e0 + 7 * e1 - e2, 6 * e0 - 3 * e1 + e2 / 2
            if before is not None:
                # Jerk and snap continue.
                constraints += [before[0] - 6 * c3 / t**3, before[1] - 24 * c4 / t**4]
            before = ((6 * c3 + 24 * c4 + 60 * c5) / t**3, (24 * c4 + 120 * c5) / t**4)
            for u in np.linspace(0.0, 1.0, 21):
                v = (c1 + 2 * c2 * u + 3 * c3 * u**2 + 4 * c4 * u**3 + 5 * c5 * u**4) / t
                a = (2 * c2 + 6 * c3 * u + 12 * c4 * u**2 + 20 * c5 * u**3) / t**2
                j = (6 * c3 + 24 * c4 * u + 60 * c5 * u**2) / t**3
                constraints += [v / velocity[joint], a / acceleration[joint], j / jerk[joint]]
    equalities = 2 * (segments - 1)
    each = equalities + 63 * segments
    lower = []
    for _ in range(joints):
        for s in range(segments):
            lower += ([0.0, 0.0] if s else []) + [-1.0] * 63
    upper = [-x for x in lower]
    assert len(lower) == joints * each
    solver = casadi.nlpsol(
        "timing",
        "ipopt",
        {"x": casadi.vertcat(h, inner), "f": casadi.sum1(h), "g": casadi.vertcat(*constraints)},
        {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes"},
    )
    ways = np.abs(np.diff(waypoints, axis=0))
    natural = np.maximum.reduce(
        [
            (1.875 * ways / velocity).max(axis=1),
            np.sqrt(5.7735 * ways / acceleration).max(axis=1),
            np.cbrt(60 * ways / jerk).max(axis=1),
        ]
    )
    start = np.r_[natural, np.zeros((count - 2) * joints * 2)]
    bounds = {"lbx": np.r_[np.full(segments, 1e-3), np.full(len(start) - segments, -np.inf)]}
    return solver, {"x0": start, "lbg": lower, "ubg": upper, **bounds}


def with_casadi(waypoints, velocity, acceleration, jerk):
    solver, arguments = quintic_programme(waypoints, velocity, acceleration, jerk)

    def plan():
        solution = solver(**arguments)
        return float(solution["f"]) if solver.stats()["success"] else float("nan")

    return plan


def with_ruckig(waypoints, velocity, acceleration, jerk):
    joints = waypoints.shape[1]
    otg = ruckig.Ruckig(joints)

    def plan():
        total = 0.0
        for start, goal in zip(waypoints, waypoints[1:]):
            given = ruckig.InputParameter(joints)
            given.current_position, given.target_position = list(start), list(goal)
            given.max_velocity, given.max_acceleration = list(velocity), list(acceleration)
            given.max_jerk = list(jerk)
            trajectory = ruckig.Trajectory(joints)
            otg.calculate(given, trajectory)
            total += trajectory.duration
        return total

    return plan


print(f"{'':10}  TOPP-RA (no jerk)      casadi quintic       Ruckig with stops")
for name, *problem in problems():
    cells = [
        timed(with_toppra(*problem), 20),
        timed(with_casadi(*problem), 3),
        timed(with_ruckig(*problem), 20),
    ]
    print(f"{name:10}" + "".join(f"  {d:8.4f} s {ms:8.3f} ms" for d, ms in cells), flush=True)
