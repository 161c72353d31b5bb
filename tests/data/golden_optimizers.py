#!/usr/bin/env python3
"""First generations of the stochastic optimizers, for golden_optimizers.json.

Plain Python, written from the methods' descriptions (the module documentation
of src/optimize and the papers named there), not from the Rust code, so that
the two check each other. Run it in this folder to write the file again:

    python3 golden_optimizers.py

A method is a generator over the problem: it yields a list of candidates, gets
back what the problem says about each, and yields again. Everything between
two returns of control to the loop is one generation, ended by `yield None`.
To add a method, write such a generator and append cases to CASES.

The order in which random numbers are drawn is part of what a seed means, so
each method states its own.
"""

import json
import math
import os

MASK = (1 << 64) - 1
INFINITY = math.inf


class Stream:
    """xoshiro256++ seeded by SplitMix64 from a mix of seed and stream number."""

    def __init__(self, seed, stream=0):
        self.seed = seed
        state = self.finalize((seed + (stream + 1) * 0x9E3779B97F4A7C15) & MASK)
        self.words = []
        for _ in range(4):
            state = (state + 0x9E3779B97F4A7C15) & MASK
            self.words.append(self.finalize(state))

    @classmethod
    def of_words(cls, words):
        """xoshiro256++ in a given state."""
        stream = cls(0)
        stream.words = list(words)
        return stream

    @staticmethod
    def finalize(z):
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        return z ^ (z >> 31)

    def unit(self):
        """Uniform in [0, 1): the upper 53 bits of the next word."""
        return (self.word() >> 11) / 2.0**53

    def word(self):
        rotate = lambda x, k: ((x << k) | (x >> (64 - k))) & MASK
        a, b, c, d = self.words
        word = (rotate((a + d) & MASK, 23) + a) & MASK
        c, d = c ^ a, d ^ b
        self.words = [a ^ d, b ^ c, c ^ ((b << 17) & MASK), rotate(d, 45)]
        return word

    def between(self, lower, upper):
        return lower + (upper - lower) * self.unit()

    def below(self, count):
        return int(self.unit() * count)


class Lanes:
    """Eight generators side by side; each word gives two numbers of 32 bits."""

    def __init__(self, seed, stream):
        mix = lambda seed, n: Stream.finalize((seed + (n + 1) * 0x9E3779B97F4A7C15) & MASK)
        own = mix(seed, stream)
        self.lanes = [
            Stream.of_words(mix(own, 4 * lane + word) for word in range(4)) for lane in range(8)
        ]

    def pairs(self, count):
        """`count` pairs; the lanes take turns, and all draw in every round."""
        words = []
        while len(words) < count:
            words += [lane.word() for lane in self.lanes]
        return [((w >> 32) / 2.0**32, (w & 0xFFFFFFFF) / 2.0**32) for w in words[:count]]


# Problems. Each answers (fitness, cost, excess); see problems in
# tests/planning/first_generations.rs.


class Bowl:
    """No constraint, nothing to repair."""

    lower, upper = [-1.0, -2.0], [1.0, 1.0]

    def appraise(self, x):
        value = 1.0 + (x[0] - 0.3) ** 2 + 2.0 * (x[1] + 0.2) ** 2
        return value, value, 0.0

    def repair(self, x):
        return x


class Fence:
    """Least sum of two durations whose product must be 1.2 at least."""

    lower, upper = [0.2, 0.3], [2.0, 2.5]

    def __init__(self, rejects):
        self.rejects = rejects

    def appraise(self, x):
        cost, excess = x[0] + x[1], max(1.2 / (x[0] * x[1]) - 1.0, 0.0)
        if self.rejects:
            return (cost if excess == 0.0 else INFINITY,) * 2 + (0.0,)
        return cost if excess == 0.0 else cost + 10.0 + 10.0 * excess, cost, excess**2

    def repair(self, x):
        """Stretches the first duration alone, a hair further than needed."""
        if x[0] * x[1] >= 1.2:
            return x
        return [min(1.2 / x[1] * (1.0 + 1e-9), self.upper[0]), x[1]]


PROBLEMS = {"bowl": Bowl(), "fence_penalty": Fence(False), "fence_reject": Fence(True)}


def anywhere(problem, random):
    return [random.between(l, u) for l, u in zip(problem.lower, problem.upper)]


def clip(x, lower, upper):
    return [min(max(v, l), u) for v, l, u in zip(x, lower, upper)]


class Memory:
    """The best candidate so far."""

    def __init__(self):
        self.fitness, self.position = INFINITY, None

    def see(self, candidates, answers):
        for x, (fitness, _, _) in zip(candidates, answers):
            if fitness < self.fitness:
                self.fitness, self.position = fitness, list(x)


# Genetic algorithms.


def single_point(a, b, random):
    """Draws the cut. Genes behind it change places."""
    cut = 1 + random.below(len(a) - 1)
    return a[:cut] + b[cut:], b[:cut] + a[cut:]


def mutated(x, problem, random):
    """Draws the gene, then its value."""
    gene = random.below(len(x))
    value = random.between(problem.lower[gene], problem.upper[gene])
    return x[:gene] + [value] + x[gene + 1 :]


def roulette(weights, random):
    """Draws where the wheel stops."""
    stop = random.unit() * sum(weights)
    for individual, weight in enumerate(weights):
        stop -= weight
        if stop < 0.0:
            return individual
    return len(weights) - 1


def ga(problem, random, settings, memory):
    """Per pair: both parents, whether to cross, how; per child whether and how
    to mutate."""
    size, elite = settings["population"], settings["elite"]
    individuals = [anywhere(problem, random) for _ in range(size)]
    values = [answer[0] for answer in (yield individuals)]
    yield None

    def tournament():
        drawn = [random.below(size) for _ in range(settings["tournament"])]
        return min(drawn, key=lambda i: values[i])

    def wheel():
        return roulette([1.0 / (1.0 + v - min(values)) for v in values], random)

    select = wheel if settings.get("roulette") else tournament
    while True:
        best = sorted(range(size), key=lambda i: values[i])[:elite]
        children = []
        while len(children) < size - elite:
            a, b = individuals[select()], individuals[select()]
            if random.unit() < settings["crossover_rate"]:
                if settings.get("blend"):
                    s = random.unit()
                    a, b = (
                        [p + s * (q - p) for p, q in zip(a, b)],
                        [q - s * (q - p) for p, q in zip(a, b)],
                    )
                else:
                    a, b = single_point(a, b, random)
            for child in (a, b):
                if random.unit() < settings["mutation_rate"]:
                    child = mutated(child, problem, random)
                children.append(child)
        children = children[: size - elite]
        answers = yield children
        individuals = [individuals[i] for i in best] + children
        values = [values[i] for i in best] + [answer[0] for answer in answers]
        yield None


def adaptive_rate(most, least, merit, merits):
    average, largest = sum(merits) / len(merits), max(merits)
    if merit < average or largest <= average:
        return most
    return most - (most - least) * (merit - average) / (largest - average)


def aga(problem, random, settings, memory):
    """The roulette's picks, the shuffle, then per pair whether and where to
    cross, and per child whether and how to mutate."""
    size = settings["population"]
    individuals = [anywhere(problem, random) for _ in range(size)]
    answers = yield individuals
    yield None
    generation = 0
    while True:
        eps = settings["penalty"] * 2.0 ** (generation / settings["penalty_doubling"])
        if settings.get("outer_penalty", True):
            values = [cost + eps * excess for _, cost, excess in answers]
        else:
            values = [fitness for fitness, _, _ in answers]
        merits = [1.0 / value for value in values]
        threshold = min(sum(merits) / size, max(merits))
        survivors = [i for i in range(size) if merits[i] >= threshold]
        weights = [merits[i] for i in survivors]
        parents = list(survivors)
        while len(parents) < size:
            parents.append(survivors[roulette(weights, random)])
        for last in range(size - 1, 0, -1):
            other = random.below(last + 1)
            parents[last], parents[other] = parents[other], parents[last]
        generation += 1
        crossing = mutating = 1.0
        if settings.get("generation_factor"):
            done = generation / settings["iterations"]
            crossing, mutating = 1.0 - 0.5 * done, 0.5 + 0.5 * done
        children = []
        # The first one's place is the best's.
        for at in range(1, size, 2):
            pair = parents[at : at + 2]
            made = [list(individuals[p]) for p in pair]
            if len(pair) == 2:
                rate = adaptive_rate(0.9, 0.1, max(merits[p] for p in pair), merits)
                if random.unit() < crossing * rate:
                    made = list(single_point(*made, random))
            for parent, child in zip(pair, made):
                rate = adaptive_rate(0.2, 0.005, merits[parent], merits)
                if random.unit() < mutating * rate:
                    child = mutated(child, problem, random)
                children.append(child)
        best = max(range(size), key=lambda i: merits[i])
        new = yield children
        individuals, answers = [individuals[best]] + children, [answers[best]] + new
        yield None


# Chaos.


def coa(problem, random, settings, memory):
    """One start per variable; new ones only where an orbit would stand still."""

    def wanders(z):
        return 1e-9 <= z <= 1.0 - 1e-9 and z not in (0.25, 0.5, 0.75)

    def start():
        while True:
            z = random.unit()
            if wanders(z):
                return z

    orbit = [start() for _ in problem.lower]
    alpha, idle = None, 0
    while True:
        points = []
        for _ in range(settings["population"]):
            x = []
            for d, (l, u) in enumerate(zip(problem.lower, problem.upper)):
                z = orbit[d]
                if alpha is None:
                    x.append(l + z * (u - l))
                else:
                    x.append(memory.position[d] + alpha * (z - 0.5) * (u - l))
                z = 4.0 * z * (1.0 - z)
                orbit[d] = z if wanders(z) else start()
            points.append(clip(x, problem.lower, problem.upper))
        best = memory.fitness
        for fitness, _, _ in (yield points):
            idle += 1
            if fitness < best:
                best, idle = fitness, 0
        if alpha is None:
            if idle >= settings["first_wave_patience"]:
                alpha, idle = settings["alpha"], 0
        else:
            while idle >= settings["second_wave_patience"]:
                alpha *= settings["alpha_shrink"]
                idle -= settings["second_wave_patience"]
        yield None


# Swarms.


def dual_pso(problem, random, settings, memory):
    """Per particle and component r1, then r2; everything anew while nothing is
    feasible."""
    size, last = settings["population"], settings["iterations"]
    lower, upper = problem.lower, problem.upper
    dimensions = range(len(lower))
    position = [anywhere(problem, random) for _ in range(size)]
    velocity = [[0.0 for _ in dimensions] for _ in range(size)]
    values = [answer[0] for answer in (yield position)]
    own, own_values = [list(x) for x in position], list(values)
    yield None
    lanes = Lanes(random.seed, 1)
    iteration = 0
    while True:
        iteration += 1
        before, values_before = [list(x) for x in own], list(own_values)
        if settings.get("h2_from_position"):
            before, values_before = [list(x) for x in position], list(values)
        if memory.position is None:
            position = [anywhere(problem, random) for _ in range(size)]
            own = [list(x) for x in position]
        else:
            inertia = 0.9 - (0.9 - 0.4) * iteration / last
            drawn = iter(lanes.pairs(size * len(lower)))
            for i in range(size):
                for d in dimensions:
                    r1, r2 = next(drawn)
                    x, vmax = position[i][d], 0.1 * (upper[d] - lower[d])
                    pull = 1.96 * r1 * (own[i][d] - x) + 1.96 * r2 * (memory.position[d] - x)
                    v = min(max(inertia * velocity[i][d] + pull, -vmax), vmax)
                    moved = x + v
                    position[i][d] = min(max(moved, lower[d]), upper[d])
                    velocity[i][d] = v if position[i][d] == moved else 0.0
        values = [answer[0] for answer in (yield [list(x) for x in position])]
        for i in range(size):
            if values[i] < own_values[i]:
                own[i], own_values[i] = list(position[i]), values[i]
        # Second search: H2.
        rows = []
        for i in range(size):
            row = [min(a, b) for a, b in zip(before[i], position[i])]
            feasible = values_before[i] < INFINITY and values[i] < INFINITY
            if feasible and row != before[i] and row != position[i]:
                rows.append((i, row))
        for attempt in range(2 if settings.get("h2_repair", True) else 1):
            if attempt == 1:
                rows = [(i, problem.repair(row)) for (i, row), v in zip(rows, found) if v == INFINITY]
            if not rows:
                break
            found = [answer[0] for answer in (yield [row for _, row in rows])]
            for (i, row), value in zip(rows, found):
                if value < own_values[i]:
                    own[i], own_values[i] = list(row), value
        yield None


def flock(weights, repairs=False):
    """A plain swarm; `weights(iteration, last)` gives inertia, factor, c and the
    largest step as a share of the box, none for a swarm without velocity."""

    def method(problem, random, settings, memory):
        size, last = settings["population"], settings["iterations"]
        lower, upper = problem.lower, problem.upper
        position = [anywhere(problem, random) for _ in range(size)]
        if repairs:
            position = [problem.repair(x) for x in position]
        velocity = [[0.0] * len(lower) for _ in range(size)]
        own, own_values = [list(x) for x in position], [INFINITY] * size
        lanes = Lanes(random.seed, 1)
        iteration = 0
        while True:
            values = [answer[0] for answer in (yield [list(x) for x in position])]
            for i in range(size):
                if values[i] < own_values[i]:
                    own[i], own_values[i] = list(position[i]), values[i]
            yield None
            iteration += 1
            inertia, factor, c, share = weights(iteration, last)
            drawn = iter(lanes.pairs(size * len(lower)))
            for i in range(size):
                for d in range(len(lower)):
                    (r1, r2), x = next(drawn), position[i][d]
                    pull = c * r1 * (own[i][d] - x) + c * r2 * (memory.position[d] - x)
                    if share is None:
                        moved = inertia * x + pull
                    else:
                        vmax = share * (upper[d] - lower[d])
                        velocity[i][d] = min(max(factor * (inertia * velocity[i][d] + pull), -vmax), vmax)
                        moved = x + velocity[i][d]
                    position[i][d] = min(max(moved, lower[d]), upper[d])
                    if position[i][d] != moved:
                        velocity[i][d] = 0.0

    return method


CHI = 2.0 / abs(2.0 - 4.1 - math.sqrt(4.1 * 4.1 - 4.0 * 4.1))


def falling(k, last):
    return 0.9 - 0.5 * k / last


def compression(k, last):
    """Han et al. 2022, eq. 17, with mu = 8 and e = 10."""
    return 8.0 ** (10.0 ** ((1 - k) / (last + 1 - k)) - 1.0)


# Golden sines.

TAU = (math.sqrt(5.0) - 1.0) / 2.0


class Section:
    """The golden section of Tanyildizi and Demir; draws where it has collapsed,
    first its lower end, then its upper one."""

    def __init__(self, random):
        self.random = random
        self.renew(-math.pi, math.pi)

    def renew(self, a, b):
        self.a, self.b = a, b
        self.x1, self.x2 = a + (1.0 - TAU) * (b - a), a + TAU * (b - a)

    def follow(self, best, answers):
        for fitness, _, _ in answers:
            if fitness < best:
                best, self.b, self.x2 = fitness, self.x2, self.x1
                self.x1 = self.a + (1.0 - TAU) * (self.b - self.a)
            else:
                self.a, self.x1 = self.x1, self.x2
                self.x2 = self.a + TAU * (self.b - self.a)
            if abs(self.x1 - self.x2) < 1e-12:
                self.renew(-math.pi * self.random.unit(), math.pi * self.random.unit())


def middle(problem, settings):
    """What positions are measured from."""
    shift = settings.get("shift")
    return [0.5 * (l + u) if shift else 0.0 for l, u in zip(problem.lower, problem.upper)]


def gold_sa(problem, random, settings, memory):
    """Per candidate one number, or two; everything anew while nothing is
    feasible."""
    section, origin = Section(random), middle(problem, settings)
    points = [anywhere(problem, random) for _ in range(settings["population"])]
    yield points
    yield None
    while True:
        if memory.position is None:
            points = [anywhere(problem, random) for _ in points]
        else:
            for i, x in enumerate(points):
                r1 = r2 = random.unit()
                if not settings.get("coupled_random", True):
                    r2 = random.unit()
                s, r2 = math.sin(2.0 * math.pi * r1), math.pi * r2
                moved = []
                for v, g, o in zip(x, memory.position, origin):
                    v, g = v - o, g - o
                    moved.append(o + v * abs(s) - r2 * s * abs(section.x1 * g - section.x2 * v))
                points[i] = clip(moved, problem.lower, problem.upper)
        best = memory.fitness
        section.follow(best, (yield points))
        yield None


def circles(problem, random, size):
    """A chaotic sequence per variable, each with a start of its own."""
    columns = []
    for l, u in zip(problem.lower, problem.upper):
        k, column = random.unit(), []
        for _ in range(size):
            k = (k + 0.2 - 0.5 / (2.0 * math.pi) * math.sin(2.0 * math.pi * k)) % 1.0
            column.append(l + k * (u - l))
        columns.append(column)
    return [list(row) for row in zip(*columns)]


def golds_pso(problem, random, settings, memory):
    """Per particle, or per component, R1, then R2; everything anew while nothing
    is feasible."""
    size, last = settings["population"], settings["iterations"]
    section, origin = Section(random), middle(problem, settings)
    position = circles(problem, random, size)
    own, own_values = [list(x) for x in position], [INFINITY] * size

    def remember(answers):
        for i, (fitness, _, _) in enumerate(answers):
            if fitness < own_values[i]:
                own[i], own_values[i] = list(position[i]), fitness

    remember((yield position))
    yield None
    iteration = 0
    while True:
        iteration += 1
        if memory.position is None:
            position = circles(problem, random, size)
            own = [list(x) for x in position]
        else:
            w = 0.4 + 0.5 * (1.0 + math.tanh(2.0 - 4.0 * iteration / last)) / 2.0
            for i in range(size):
                moved = []
                for d, o in enumerate(origin):
                    if d == 0 or settings.get("draw_per_component"):
                        r1, r2 = 2.0 * math.pi * random.unit(), math.pi * random.unit()
                    x, p, g = position[i][d] - o, own[i][d] - o, memory.position[d] - o
                    pull = 2.0 * abs(math.sin(r1)) * (p - x)
                    golden = 2.0 * r2 * math.sin(r1) * abs(section.x1 * g - section.x2 * x)
                    moved.append(o + 0.5 * (w * x + pull - golden))
                position[i] = clip(moved, problem.lower, problem.upper)
        best = memory.fitness
        answers = yield position
        remember(answers)
        if settings.get("golden_update", True):
            section.follow(best, answers)
        yield None


METHODS = {
    "aga": aga,
    "cfpso": flock(lambda k, last: (1.0, CHI, 2.05, 1.0)),
    "coa": coa,
    "dual_pso": dual_pso,
    "ga": ga,
    "gold_sa": gold_sa,
    "golds_pso": golds_pso,
    "improved_pso": flock(lambda k, last: (0.5, compression(k, last), 2.0, 0.1), repairs=True),
    "pso": flock(lambda k, last: (1.0, 1.0, 2.0, 0.1)),
    "pso_linear": flock(lambda k, last: (falling(k, last), 1.0, 2.0, 0.1)),
    "spso": flock(lambda k, last: (falling(k, last), 1.0, 2.0, None)),
}

GA = {"population": 4, "elite": 1, "tournament": 2, "crossover_rate": 0.8, "mutation_rate": 0.4}
AGA = {"population": 4, "iterations": 10, "penalty": 10.0, "penalty_doubling": 2.0}
COA = {
    "population": 4,
    "first_wave_patience": 4,
    "second_wave_patience": 2,
    "alpha": 0.5,
    "alpha_shrink": 0.9,
}
DUAL = {"population": 4, "iterations": 6}

# Seeds under which much happens: mutation, improvement, repaired rows and
# particles, collapsed golden sections, and for dual_pso and gold_sa 77 and golds_pso 17 an
# initial generation without anything feasible.
CASES = [
    ("ga", "bowl", 10, 4, GA),
    ("ga", "bowl", 2, 4, GA | {"elite": 2, "roulette": True, "blend": True}),
    ("ga", "fence_penalty", 3, 4, GA | {"population": 5, "elite": 2}),
    ("aga", "fence_penalty", 5, 4, AGA),
    ("aga", "fence_penalty", 5, 4, AGA | {"population": 5, "outer_penalty": False}),
    ("aga", "bowl", 2, 4, AGA | {"population": 7, "generation_factor": True}),
    ("coa", "bowl", 1, 7, COA),
    ("coa", "fence_penalty", 2, 7, COA),
    ("dual_pso", "fence_reject", 193, 4, DUAL),
    ("dual_pso", "fence_reject", 77, 4, DUAL),
    ("dual_pso", "fence_reject", 193, 4, DUAL | {"h2_repair": False}),
    ("dual_pso", "fence_reject", 36, 4, DUAL | {"h2_from_position": True}),
    ("dual_pso", "bowl", 2, 4, DUAL),
    ("pso", "bowl", 4, 4, DUAL),
    ("pso_linear", "bowl", 5, 4, DUAL | {"population": 5}),
    ("cfpso", "bowl", 6, 4, DUAL),
    ("spso", "bowl", 7, 4, DUAL | {"population": 9}),
    ("improved_pso", "fence_penalty", 9, 4, DUAL),
    ("improved_pso", "bowl", 9, 4, DUAL | {"population": 5}),
    ("gold_sa", "bowl", 11, 7, {"population": 12}),
    ("gold_sa", "fence_penalty", 12, 4, {"population": 4, "coupled_random": False, "shift": True}),
    ("gold_sa", "fence_reject", 77, 4, {"population": 4}),
    ("golds_pso", "bowl", 6, 7, DUAL | {"population": 12}),
    ("golds_pso", "fence_penalty", 14, 4, DUAL | {"golden_update": False, "shift": True}),
    ("golds_pso", "fence_reject", 17, 4, DUAL | {"draw_per_component": True}),
]


def run(method, problem_name, seed, generations, settings):
    problem, memory = PROBLEMS[problem_name], Memory()
    search = METHODS[method](problem, Stream(seed), settings, memory)
    told, candidates = [], next(search)
    for _ in range(generations):
        evaluated = []
        while candidates is not None:
            answers = [problem.appraise(x) for x in candidates]
            evaluated += [list(x) for x in candidates]
            memory.see(candidates, answers)
            candidates = search.send(answers)
        best = None if memory.position is None else memory.fitness
        told.append({"evaluated": evaluated, "best": best, "best_position": memory.position})
        candidates = next(search)
    return told


def main():
    cases = []
    for method, problem, seed, generations, settings in CASES:
        told = run(method, problem, seed, generations, settings)
        case = {"optimizer": method, "problem": problem, "seed": seed, "settings": settings}
        cases.append(case | {"generations": told})
    with open(os.path.join(os.path.dirname(__file__), "golden_optimizers.json"), "w") as file:
        file.write("[\n" + ",\n".join(json.dumps(case) for case in cases) + "\n]\n")


if __name__ == "__main__":
    main()
