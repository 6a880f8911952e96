"""Writes faults into a source so that one build holds them all, each dormant until the environment asks for its number.

An expression becomes (BCCSPLAT_MUTANT(n) ? (mutated) : (original)), a statement { if (!BCCSPLAT_MUTANT(n)) statement }. Lines
stay where they are, so that what the compiler does not take is found by the lines that it names."""
import re

# Read by every program and library of its own; `chosen` is the mutant that is awake, and what was reached is told at the end.
HEADER = '''#pragma once
#include <cstdio>
#include <cstdlib>
%(ignored)s
struct BccsplatMutants {
  int chosen = 0;
  bool reached[%(size)d] = {};
  BccsplatMutants() {
    if (const char* number = std::getenv("BCCSPLAT_MUTANT")) chosen = std::atoi(number);
  }
  ~BccsplatMutants() {
    const char* path = std::getenv("BCCSPLAT_MUTANTS_REACHED");
    FILE* file = path ? std::fopen(path, "a") : nullptr;
    for (int n = 0; file && n < %(size)d; ++n)
      if (reached[n]) std::fprintf(file, "%%d\\n", n);
    if (file) std::fclose(file);
  }
};
inline BccsplatMutants bccsplat_mutants;
#define BCCSPLAT_MUTANT(n) (bccsplat_mutants.reached[n] = true, bccsplat_mutants.chosen == (n))
'''
IGNORED = '''conversion sign-conversion sign-compare type-limits parentheses logical-op duplicated-branches bool-operation
int-in-bool-context maybe-uninitialized uninitialized array-bounds unused-variable unused-value unused-function
unused-but-set-variable div-by-zero stringop-overflow stringop-overread aggressive-loop-optimizations tautological-compare
nonnull dangling-else shift-count-overflow shift-count-negative overflow'''.split()

OPENING = {')': '(', ']': '[', '}': '{'}
NOT_IN_EXPRESSIONS = {'return', 'else', 'do', 'case', 'throw', 'if', 'for', 'while', 'switch', 'default', 'goto'}


def header(size):
    return HEADER % {'size': size + 1, 'ignored': '\n'.join(f'#pragma GCC diagnostic ignored "-W{w}"' for w in IGNORED)}


def partner(code, i, step):
    """Where the bracket of code[i] is closed (step 1) or opened (-1); None when it is not."""
    depth = 0
    while 0 <= i < len(code):
        if code[i] in '([{)]}':
            depth += 1 if (code[i] in '([{') == (step == 1) else -1
            if depth == 0:
                return i
        i += step
    return None


def assigns(code, i):
    """Whether the = at i is an assignment, also with an operator."""
    return code[i + 1] != '=' and (code[i - 1] not in '=!<>' or code[i - 2:i] in ('<<', '>>'))


def begin_of(code, at):
    """Where the expression begins that code[at] is part of: behind what binds less than any operator."""
    i = at
    while i > 0:
        c = code[i - 1]
        if c in OPENING:
            opened = partner(code, i - 1, -1)
            block = c == '}' and re.match(r'\s*(\w|\+\+|--|!|~)', code[i:at + 1])
            head = c == ')' and opened and re.search(r'\b(if|for|while|switch|constexpr)\s*$', code[max(0, opened - 20):opened])
            if opened is None or block or head:
                break
            i = opened
        elif c in '([{,;?' or (c == '=' and assigns(code, i - 1)) or (c == ':' and code[i - 2] != ':'):
            break
        elif c == '\n' and code[code.rfind('\n', 0, i - 1) + 1:i - 1].lstrip().startswith('#'):
            break
        elif c.isalnum() or c == '_':
            word = re.search(r'\w+$', code[max(0, i - 100):i])[0]
            if word in NOT_IN_EXPRESSIONS:
                break
            i -= len(word)
        else:
            i -= 2 if c == ':' else 1
    return i + len(code[i:]) - len(code[i:].lstrip()) if i < at else at


def end_of(code, at, whole):
    """Where it ends; with `whole` also behind assignments and choices."""
    i = at
    while i < len(code):
        c = code[i]
        if c in '([{':
            closed = partner(code, i, 1)
            if closed is None:
                break
            i = closed + 1
        elif c in ')]},;' or (c == '?' and not whole):
            break
        elif c == ':' and code[i + 1] != ':' and not whole:
            break
        elif c == '=' and assigns(code, i) and not whole:
            while code[i - 1] in '+-*/%&|^<>':
                i -= 1
            break
        else:
            i += 2 if c == ':' else 1
    return at + len(code[at:i].rstrip())


def place_of(code, fault):
    """Begin and end of what is written twice, and the text that stands for the fault within it; None where there is none."""
    instead, start, end = fault.instead, fault.start, fault.end
    if fault.kind == 'call':
        begin = start + len(code[start:end]) - len(code[start:end].lstrip())
        before = code[:begin].rstrip()
        return (begin, end, '') if before[-1:] in '{};:)' or before.endswith('else') else None
    if code[start:end] == '0; ':
        return start, start + 1, '1'
    if code[start:end] == '!':
        instead = '!!'  # the same, and of the same type
    begin, stop = begin_of(code, start), end_of(code, end, bool(re.match(r' [+-]= ', code[start:end])))
    return (begin, stop, instead) if begin <= start and stop >= end else None


def place_all(code, faults):
    """Of faults in their order those that one file can hold together, with their places: at most one in a line, none within
    another. And those that have no place at all."""
    taken, placed, without = [], [], []
    for fault in faults:
        place = place_of(code, fault)
        if place is None:
            without.append(fault)
            continue
        first, last = code.count('\n', 0, place[0]), code.count('\n', 0, place[1])
        if all(last < a or first > b for a, b in taken):
            taken.append((first, last))
            placed.append((fault, place))
    return placed, without


def rewritten(text, plain, numbered, header_path):
    """The source with faults: `numbered` is of (n, fault, place), `plain` the text without comments."""
    for n, fault, (begin, end, instead) in sorted(numbered, key=lambda m: -m[2][0]):
        if fault.kind == 'call':
            new = f'{{ if (!BCCSPLAT_MUTANT({n})) {text[begin:end]} }}'
        else:
            mutated = plain[begin:fault.start] + instead + (plain[fault.end:end] if fault.end <= end else '')
            mutated = re.sub(r'\s*\n\s*', ' ', mutated)
            new = f'(BCCSPLAT_MUTANT({n}) ? ({mutated}) : ({text[begin:end]}))'
        text = text[:begin] + new + text[end:]
    return f'#include "{header_path}"\n#line 1\n{text}'
