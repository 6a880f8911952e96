"""Covering arrays: few cases that hold every pair (or triple) of choices of different options, but those that exclude
each other. Greedy and seeded: the same cases each time."""
import itertools
import random


def cases(counts, excludes, strength=2, candidates=20):
    """Lists of a choice for each option, of counts[o] choices, and the tuples that no case holds. excludes((option, choice),
    (option, choice)) says what cannot be in one case."""
    dice = random.Random(20)
    every = [[(o, c) for c in range(n)] for o, n in enumerate(counts)]

    def fits(chosen, one):
        return not any(excludes(other, one) for other in chosen)

    missing = {t for group in itertools.combinations(every, strength) for t in itertools.product(*group)
               if all(fits(t[:i], t[i]) for i in range(1, strength))}

    def adds(chosen, one):
        return sum(tuple(sorted((*some, one))) in missing for some in itertools.combinations(chosen, strength - 1))

    def candidate():
        chosen = list(dice.choice(left))
        for o in dice.sample(range(len(counts)), len(counts)):
            if any(option == o for option, _ in chosen):
                continue
            possible = [one for one in every[o] if fits(chosen, one)]
            if not possible:
                return None
            dice.shuffle(possible)
            chosen.append(max(possible, key=lambda one: adds(chosen, one)))
        return sorted(chosen)

    found, without = [], []
    while missing:
        left = sorted(missing)
        tried = [c for c in (candidate() for _ in range(candidates)) if c]
        held = [missing & set(itertools.combinations(c, strength)) for c in tried]
        best = max(range(len(tried)), key=lambda i: len(held[i]), default=None)
        if best is None or not held[best]:
            without.append(left[0])
            missing.remove(left[0])
            continue
        found.append([choice for _, choice in tried[best]])
        missing -= held[best]
    return found, without


def reduced(case, fails):
    """Drops choices of a case that fails, one after the other, as long as it does: mostly two are left."""
    again = True
    while again:
        again = False
        for option, choice in enumerate(case):
            less = case[:option] + [0] + case[option + 1:]
            if choice and fails(less):
                case, again = less, True
    return case
