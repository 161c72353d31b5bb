"""Nanoseconds per evaluation of the particle swarms of pyswarms and pygmo:
30 particles, 30 dimensions, 1000 iterations, the optimizer's own work included.

pyswarms evaluates numpy functions of the whole swarm, pygmo its own functions
in C++ (it offers no sphere; Rosenbrock is its cheapest smooth one).
"""

import statistics
import time

import numpy as np
import pygmo
import pyswarms

DIMENSION, PARTICLES, ITERATIONS = 30, 30, 1000


def sphere(x):
    return (x * x).sum(axis=1)


def ackley(x):
    mean_square = (x * x).mean(axis=1)
    return 20 + np.e - 20 * np.exp(-0.2 * np.sqrt(mean_square)) - np.exp(np.cos(2 * np.pi * x).mean(axis=1))


def griewank(x):
    roots = np.sqrt(np.arange(1, x.shape[1] + 1))
    return 1 + (x * x).sum(axis=1) / 4000 - np.cos(x / roots).prod(axis=1)


def nanoseconds(run, runs=7):
    times = [run(seed) / (PARTICLES * ITERATIONS) * 1e9 for seed in range(runs)]
    return f"{min(times):.0f} to {statistics.median(times):.0f} ns (least and median of {runs} runs)"


def with_pyswarms(function, half_width):
    def run(seed):
        np.random.seed(seed)
        edge = half_width * np.ones(DIMENSION)
        swarm = pyswarms.single.GlobalBestPSO(
            PARTICLES, DIMENSION, {"c1": 2, "c2": 2, "w": 0.7}, bounds=(-edge, edge)
        )
        start = time.perf_counter()
        swarm.optimize(function, iters=ITERATIONS, verbose=False)
        return time.perf_counter() - start

    return run


def with_pygmo(problem):
    def run(seed):
        swarm = pygmo.algorithm(pygmo.pso(gen=ITERATIONS, seed=seed))
        population = pygmo.population(problem, PARTICLES, seed=seed)
        start = time.perf_counter()
        swarm.evolve(population)
        return time.perf_counter() - start

    return run


for name, function, half_width in [
    ("Sphere", sphere, 100), ("Ackley", ackley, 32), ("Griewank", griewank, 600),
]:
    print(f"pyswarms {name}: {nanoseconds(with_pyswarms(function, half_width))}")
for problem in [pygmo.rosenbrock(DIMENSION), pygmo.ackley(DIMENSION), pygmo.griewank(DIMENSION)]:
    name = pygmo.problem(problem).get_name()
    print(f"pygmo {name}: {nanoseconds(with_pygmo(problem))}")
