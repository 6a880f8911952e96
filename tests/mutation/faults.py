"""What small faults there are in the sources, and the order in which they are made."""
import collections
import hashlib
import os
import re
import subprocess

TOP = os.path.realpath(os.path.join(os.path.dirname(__file__), '..', '..'))

# Name, pattern, what stands in the code in the pattern's place.
OPERATORS = [
    ('sign', r' \+ (?!\+)', [' - ']), ('sign', r' - (?!-)', [' + ']), ('sign', r' \+= ', [' -= ']), ('sign', r' -= ', [' += ']),
    ('bound', r' < (?!<)', [' <= ', ' >= ']), ('bound', r' <= ', [' < ', ' > ']), ('bound', r' > (?!>)', [' >= ', ' <= ']),
    ('bound', r' >= ', [' > ', ' < ']), ('bound', r' == ', [' != ']), ('bound', r' != ', [' == ']),
    ('off by one', r' [+-] 1\b(?![.\d])', ['']), ('off by one', r'(?<= )0; (?=\w+ [<!])', ['1; ']),
    ('factor', r' \* 2\b(?![.\d])', ['']), ('factor', r' \* (?=[\w(])', [' / ']), ('factor', r' / (?=[\w(])', [' * ']),
    ('factor', r'\b0\.5f?\b', ['0.4f']), ('factor', r'\b2 \* ', ['']),
    ('logic', r' && ', [' || ']), ('logic', r' \|\| ', [' && ']), ('logic', r'(?<=[ (])!(?=\w)', ['']),
    ('logic', r'\btrue\b', ['false']), ('logic', r'\bfalse\b', ['true']),
    ('extreme', r'\bstd::max\b(?=[<({])', ['std::min']), ('extreme', r'\bstd::min\b(?=[<({])', ['std::max']),
    ('axis', r'\[0\]', ['[1]']), ('axis', r'\[1\]', ['[0]']), ('axis', r'\[2\]', ['[1]']),
    ('call', r'^ +(?:[\w.]|->|::)+\([^;{}]*\);$', ['  ;']),
]
# What the compiler has to know cannot be chosen at run time.
NOT_AT_RUN_TIME = re.compile(r'\s*(#|template\b|using\b|namespace\b|struct\b|class\b|enum\b|case\b|static_assert\b)|.*\bconstexpr\b')
ASIDE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.DOTALL)

# `start` and `end` are where in the file the pattern lies, `instead` what is to stand there.
Fault = collections.namedtuple('Fault', 'room file line kind before after start end instead')


def blank(text, inside_of_strings):
    """The text with comments blank, and strings too where asked; everything stays in its place."""
    def blanked(m):
        if m[0][0] == '/':
            return re.sub(r'[^\n]', ' ', m[0])
        return m[0][0] + re.sub(r'[^\n]', ' ', m[0][1:-1]) + m[0][-1] if inside_of_strings else m[0]
    return ASIDE.sub(blanked, text)


def room_of(path):
    return '/'.join(path.split('/')[:2])


def faults_of(path, text):
    lines, start = text.split('\n'), 0
    for number, (line, code) in enumerate(zip(lines, blank(text, True).split('\n')), 1):
        if not NOT_AT_RUN_TIME.match(code):
            for kind, pattern, replacements in OPERATORS:
                for m in re.finditer(pattern, code):
                    for r in replacements:
                        yield Fault(room_of(path), path, number, kind, line, line[:m.start()] + r + line[m.end():],
                                    start + m.start(), start + m.end(), r)
        start += len(line) + 1


def key_of(fault):
    return '\t'.join((fault.room, fault.file, fault.kind, fault.before.strip(), fault.after.strip()))


def by_room(seed):
    """Room -> all its faults in their order: kind after kind, of one kind by a number that hangs on nothing but the seed and
    the fault, so that the order stays when sources change."""
    rooms = collections.defaultdict(lambda: collections.defaultdict(list))
    listed = subprocess.run(['git', 'ls-files', 'src', 'formats', 'importers'], cwd=TOP, capture_output=True, text=True,
                            check=True).stdout.split('\n')
    for path in listed:
        if path.endswith('.cpp') or path.endswith('-inl.h'):
            with open(os.path.join(TOP, path)) as f:
                for fault in faults_of(path, f.read()):
                    rooms[fault.room][fault.kind].append(fault)
    ordered = {}
    for room in sorted(rooms):
        queues = [sorted(faults, key=lambda f: hashlib.sha256(f'{seed}\t{key_of(f)}'.encode()).digest(), reverse=True)
                  for _, faults in sorted(rooms[room].items())]
        ordered[room] = []
        while any(queues):
            ordered[room] += [queue.pop() for queue in queues if queue]
    return ordered
