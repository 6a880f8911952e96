"""Faults lie where two features meet. Every pair of choices that may go together is in one of few cases, each of which is
an import whose file is compared with its source in every way the tool has; every pair that may not ends in its sentence.
BCCSPLAT_LONG=1: triples."""
import array
import functools
import itertools
import json
import math
import os
import resource
import shutil
import struct
import subprocess
import unittest

from cases_netcdf_test import classic
from covering import cases, reduced
from harness import BCC4, CODES, LONG, Nrrd, ToolTest, has_openvdb, has_reader, main, read_png

# ---- The options: the first choice is what nobody asks for ----


def choice(*args, **changes):
    """Arguments of import, and what else changes of the case."""
    return args, changes


OPTIONS = {
    # The series.
    'frames': {'9': choice(), '1': choice(frames=1)},
    'data': {'blob': choice(), 'far': choice(data='far'), 'labels': choice(data='labels')},
    'type': {'f32': choice(), 'u8': choice(dtype='u8'), 'i16': choice(dtype='i16')},
    'missing': {'none': choice(), 'hole': choice('--on-nonfinite', 'hole', missing=True), 'clamp': choice('--on-nonfinite', 'clamp', missing=True)},
    'thin': {'no': choice(), 'z': choice(thin=True)},
    'axes': {'even': choice(), 'uneven': choice(uneven=True)},
    'time': {'numbers': choice(), 'times': choice(times=True), 'calendar': choice(calendar=True)},
    'units': {'none': choice(), 'spacing': choice('--spacing', '2,1,.5', spacing=True), 'mm': choice(units=True)},
    'channels': {'1': choice(), '2': choice(channels=2)},
    # The file.
    'store': {'samples': choice('--store', 'samples'), 'wavelets': choice('--store', 'wavelets'), 'chosen': choice()},
    'lattice': {'d4star': choice(lattice='d4star'), 'cc': choice(lattice='cc'), 'chosen': choice(lattice='auto'),
                'density': choice('--density', .7, lattice='auto')},
    'scale': {'1': choice(), '1.2': choice('--scale', 1.2)},
    'levels': {'none': choice('--levels', 'none'), '1': choice('--levels', 1)},
    'kept': {'chosen': choice(), 'exact': choice('--exact'), 'u8': choice('--quantize', 'u8')},
    'bound': {'none': choice(), 'abs': choice('--abs', .5, abs=.5), 'psnr': choice('--psnr', 40, psnr=40)},
    'ends': {'own': choice(), 'predict': choice('--ends', 'predict'), 'periodic': choice('--ends', 'periodic')},
    'faces': {'own': choice(), 'predict': choice('--faces', 'x'), 'periodic': choice('--periodic', 'y')},
    'lowpass': {'no': choice(), 'yes': choice('--lowpass')},
    'measure': {'own': choice(), 'all': choice('--measure', 'all')},
    'written': {'whole': choice(), 'parts': choice(way='parts'), 'blocks': choice('--blocks', way='blocks'), 'appended': choice('--exact', way='appended'),
                'resumed': choice(way='resumed'), 'live': choice('--live', 1)},
    # What is made of it.
    'export': {'nrrd': choice(), **{name: choice(export=name) for name in ('raw', 'nii', 'nc', 'tif', *(['vdb'] if has_openvdb() else []))}},
    'look': {'usual': choice(), 'iso': choice(render=['--mode', 'iso', '--smooth-edges', 'off']), 'xray': choice(render=['--mode', 'xray']),
             'trail': choice(render=['--trail', '-2']), 'plane': choice(render=['--plane', '.3,.4,0,1,-8.5'])},
}

# ---- What does not go together: "option=choice|choice", or "option" for all of its choices but the first. Two are never in
# one case; more than two may be, and then the case may end so ----

# With which exit code, and a part of the sentence.
REFUSED = [
    (('frames=1', 'ends=periodic'), 2, 'a periodic series needs the number of its frames in dims[3], at least 2'),
    (('lattice=cc', 'lowpass'), 2, 'a low-pass is of use on D4* and BCC only'),
    (('lattice=density', 'scale'), 2, '--density chooses the distances that --scale and --time-scale give'),
    (('store=wavelets', 'written=blocks'), 2, 'the step of wavelets is chosen by whole frames'),
    (('store=wavelets', 'written=appended'), 2, '--exact keeps samples as they are, and --store wavelets rounds them'),  # which these say
    (('bound', 'written=appended'), 2, 'import all anew'),
    (('lattice=density', 'written=appended'), 2, '--density: '),
    (('ends=periodic', 'written=parts|blocks'), 2, 'a periodic series is not written in parts'),
    (('ends=periodic', 'written=appended'), 2, 'ends where it begins, so that none goes on'),
    (('ends=periodic', 'written=live'), 2, 'a periodic series is not looked at while it is written'),
    (('faces=periodic', 'written=blocks'), 2, 'what follows the last sample of a --periodic axis is far away'),
    (('lowpass', 'written=blocks'), 2, '--lowpass holds whole frames'),
    (('store=wavelets', 'written=parts', 'bound=none'), 1, 'parts cannot: make the plan with --abs'),
]
# Pairs that end so with some data.
MAY_END = [
    (('store=wavelets', 'kept=exact'), '--exact keeps samples as they are, and --store wavelets rounds them'),  # always: wavelets_test.py
    (('bound=psnr', 'written=parts|blocks'), 'parts cannot: make the plan with --abs'),
    (('store=wavelets', 'lattice=density', 'type=u8', 'faces=predict'), 'samples stored in steps of 1 are off by 0.5'),
    (('store=wavelets', 'type=u8', 'bound=abs'), 'samples stored in steps of 1 are off by 0.'),
    (('store=wavelets', 'lattice=cc', 'kept=u8', 'bound=abs'), 'made of rounded samples'),  # what filters may make of those of bytes
    (('lattice=chosen|density', 'lowpass'), 'a low-pass is of use on D4* and BCC only'),
    (('lattice=chosen', 'written=appended'), 'import all anew'),
    (('channels=2', 'levels'), 'coarser levels are means, which labels have none of'),  # the second one looks like labels
]
# Pairs that say nothing, or of which one takes the place of the other.
NO_SENSE = [
    ('units=mm', 'axes=uneven'), ('units=mm', 'time=calendar'),  # either file has its own
    ('units=spacing', 'axes=uneven'),
    ('type=u8|i16', 'missing'),  # of numbers that are not there
    ('type=u8', 'data=far'), ('kept=u8', 'data=far'),  # nor are these
    ('frames=1', 'written=parts|appended'),  # of nothing
    ('frames=1', 'look=trail|plane'),  # of time
]
# Faults that are not mended yet: a part of what is wrong, and the fault. Each has to fail: where it does not, its row goes.
KNOWN = [
    (('data=far', 'type=i16', 'levels', 'written=parts'), 'parts is not byte for byte',
     'errors of levels are measured about air in parts, and about the base of the field in one go'),
    (('type=u8', 'channels=2', 'lattice=density', 'bound=psnr'), 'export is off by',
     'an export is air where nothing is stored, and verify measures the field there'),
    (('data=far', 'type=i16', 'bound=abs', 'written=blocks'), 'off the reference', 'ripples of a field that blocks keep about air are drawn otherwise'),
]

NAMES = [(o, c) for o, choices in OPTIONS.items() for c in choices]
COUNTS = [len(choices) for choices in OPTIONS.values()]


def numbers_of(text):
    option, _, listed = text.partition('=')
    o = list(OPTIONS).index(option)
    found = [(o, c) for c, name in enumerate(OPTIONS[option]) if (name in listed.split('|') if listed else c)]
    assert found and (not listed or len(found) == len(listed.split('|'))), text
    return found


def groups_of(together):
    return itertools.product(*map(numbers_of, together))


ROWS = [(row[0], row[2]) for row in REFUSED] + [(row[0], row[1]) for row in KNOWN] + [(pair, '') for pair in NO_SENSE]
EXCLUDED = {frozenset(group) for together, _ in ROWS if len(together) == 2 for group in groups_of(together)}


def excludes(one, other):
    return frozenset((one, other)) in EXCLUDED


def allowed(case):
    return not any(excludes(*pair) for pair in itertools.combinations(enumerate(case), 2))


def may_end_in(case, said):
    return any(said and text in said and any(all(case[o] == c for o, c in group) for group in groups_of(together))
               for together, text in MAY_END + [row for row in ROWS if len(row[0]) > 2])


def name_of(case):
    return ', '.join(f'{o}={list(OPTIONS[o])[c]}' for o, c in zip(OPTIONS, case) if c) or 'nothing'


def case_of(*chosen):
    case = [0] * len(OPTIONS)
    for o, c in chosen:
        case[o] = c
    return case


# ---- A case ----


class Wrong(Exception):
    """What came out is not the truth."""


class Ended(Exception):
    """A command ended with another code than 0."""

    def __init__(self, code, text):
        super().__init__(f'{code}: {text}')
        self.code, self.text = code, text


def demand(holds, *text):
    if not holds:
        raise Wrong(' '.join(map(str, text)))


class Case:
    frames, thin, data, dtype, missing, uneven, channels = 9, False, 'blob', 'f32', False, False, 1
    times = calendar = spacing = units = False
    lattice, abs, psnr, way, export, render = 'd4star', None, None, 'whole', 'nrrd', []

    def __init__(self, numbers, folder):
        self.folder, self.args = folder, []
        for (option, choices), number in zip(OPTIONS.items(), numbers):
            args, changes = list(choices.values())[number]
            self.args += args
            self.__dict__.update(changes)
        self.dims = (16, 13, 1 if self.thin else 9, self.frames)
        if not (self.frames == 1 and self.lattice == 'd4star'):
            self.args += ['--lattice', self.lattice]
        self.moments = [.5 * t + (.05 * t * t if self.times else 0) for t in range(self.frames)]

    # The series.

    def value(self, x, y, z, t, channel=0):
        turn = 2 * math.pi * t / self.dims[3]
        r2 = (x - 7.5 - 1.2 * math.cos(turn)) ** 2 + (y - 6 - 1.2 * math.sin(turn)) ** 2 + (0 if self.thin else (z - 4.5) ** 2)
        blob = 100 * math.exp(-r2 / 9)
        if channel == 1:
            return 1 if x < 8 else 2
        if self.missing and ((x > 10 and y > 8) or (7 * x + 5 * y + 3 * z + 11 * t) % 37 == 0):
            return math.nan
        v = {'blob': blob, 'far': 1000 + blob, 'labels': math.floor(blob / 26)}[self.data]
        return v if self.dtype == 'f32' else math.floor(v + .5)

    @functools.lru_cache(None)
    def samples(self, frames=None, channel=0):
        nx, ny, nz, nt = self.dims
        values = (self.value(x, y, z, t, channel) for t in range(frames or nt) for z in range(nz) for y in range(ny) for x in range(nx))
        return array.array(CODES[self.dtype], values)

    def places(self, axis):
        step = (2, 1, .5)[axis] if self.spacing else (.5, 1, 2)[axis] if self.units else 1
        return [step * i + (.02 * i * i if self.uneven and axis == 0 else 0) for i in range(self.dims[axis])]

    def write(self, name, data):
        with open(os.path.join(self.folder, name), 'wb') as f:
            f.write(data)

    def source(self, frames):
        """Writes the first frames; returns the arguments that read them."""
        channels = [self.samples(frames, c) for c in range(self.channels)]
        size = len(channels[0]) // frames
        args = ['--dt', .5] if not self.times else ['--times', ','.join(map(str, self.moments[:frames]))]
        if self.uneven or self.calendar:
            names, kind = 'time lev lat lon'.split(), {'f32': 'float', 'u8': 'byte', 'i16': 'short'}[self.dtype]
            since = {'units': 'days since 2000-02-27', 'calendar': 'noleap'} if self.calendar else {'units': 's'}
            axes = [('time', 'double', ['time'], since, self.moments[:frames])]
            axes += [(n, 'double', [n], {'units': 'm'}, self.places(a)) for n, a in (('lev', 2), ('lat', 1), ('lon', 0))]
            more = {'_Unsigned': 'true'} if self.dtype == 'u8' else {}
            fields = [(f'v{c}', kind, names, more, [v - 256 if self.dtype == 'u8' and v > 127 else v for v in values])
                      for c, values in enumerate(channels)]
            self.write('a.nc', classic(axes + fields, list(zip(names, (frames, *self.dims[2::-1])))))
            return ['a.nc'] + (['--channel', ','.join(f'v{c}' for c in range(self.channels))])
        data = b''.join(channels[c][t * size:(t + 1) * size].tobytes() for t in range(frames) for c in range(self.channels))
        sizes = [*self.dims[:3], frames]
        if self.units and self.channels == 1:
            kind = {'f32': 'float', 'u8': 'uint8', 'i16': 'int16'}[self.dtype]
            head = (f'NRRD0004\ntype: {kind}\ndimension: 4\nsizes: {" ".join(map(str, sizes))}\nspacings: .5 1 2 .5\n'
                    'units: "mm" "mm" "mm" "s"\nkinds: space space space time\nendian: little\nencoding: raw\n\n')
            self.write('a.nrrd', head.encode() + data)
            return ['a.nrrd'] + (args if self.times else [])
        self.write('a.raw', data)
        if self.units:
            args += ['--spacing', '.5,1,2']
        return ['a.raw', '--dims', ','.join(map(str, sizes)), '--dtype', self.dtype, *args] + (['--count', self.channels] if self.channels > 1 else [])

    # The file.

    def bcc4(self, *args, limit=None):
        def less():
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        if args[0] in ('import', 'export', 'render', 'verify'):
            args = (*args, '--threads', 1)  # so small a file is read sooner than they begin
        run = subprocess.run([BCC4, *map(str, args)], capture_output=True, text=True, cwd=self.folder, timeout=120, preexec_fn=less if limit else None)
        if run.returncode:
            raise Ended(run.returncode, run.stderr.strip())
        return run.stdout

    def json(self, *args):
        return json.loads(self.bcc4(*args, '--json'))

    def read(self, name):
        with open(os.path.join(self.folder, name), 'rb') as f:
            return f.read()

    def make(self):
        """Writes the file in the way that is asked for; returns its name."""
        source = self.source(self.frames)
        go = ['import', *source, *self.args, '--overwrite']
        if self.way in ('parts', 'blocks'):
            self.bcc4(*go, '--dry-run', '--plan', 'plan.json')
            half = (self.frames - 1) // 2
            pieces = [['--part', f'0-{half}'], ['--part', f'{half + 1}-{self.frames - 1}']] if self.way == 'parts' else [['--block', ':9,,'], ['--block', '9:,,']]
            for n, piece in enumerate(pieces):
                self.bcc4('import', '--plan', 'plan.json', *piece, '-o', f'p{n}.bcc4', '--quiet')
            self.bcc4('concat', 'p1.bcc4', 'p0.bcc4', '-o', 'v.bcc4', '--quiet')
        self.report = self.json(*go, '-o', 'whole.bcc4')
        if self.way == 'appended':
            first = self.source(self.frames - 3)
            self.bcc4('import', *first, *self.args, '-o', 'v.bcc4', '--quiet')
            self.source(self.frames)
            self.bcc4('import', *source, *self.args, '-o', 'v.bcc4', '--append', '--quiet')
        if self.way == 'resumed':
            try:
                self.bcc4(*go, '-o', 'v.bcc4', '--quiet', limit=max(len(self.read('whole.bcc4')) * 2 // 3, 1))
                raise Wrong('an import that cannot write ended well')
            except Ended:
                self.bcc4(*go, '-o', 'v.bcc4', '--resume', '--quiet')
        if self.way == 'whole':
            return 'whole.bcc4', source
        # What is chosen for a shorter series may be another lattice, and errors of levels stay those that it had.
        same = self.way != 'appended' or not ({'--levels', 1} <= set(self.args) or self.lattice == 'auto' or '--store' not in self.args)
        demand(not same or self.read('v.bcc4') == self.read('whole.bcc4'), self.way, 'is not byte for byte what one import writes')
        return 'v.bcc4', source

    # The truth.

    def check(self):
        name, source = self.make()
        self.check_file(name, source)
        self.check_places(name)
        self.check_export(name)
        self.check_picture(name)

    def check_file(self, name, source):
        verified = self.json('verify', name, '--against', source[0])
        demand(verified['ok'], 'verify', verified)
        source = self.samples()
        finite = sum(v == v for v in source)
        self.peak = max(v for v in source if v == v) - min(v for v in source if v == v)
        clamped = 'clamp' in self.args
        self.worst, self.exact = verified['max_abs'], verified['exported']['max_abs']
        if self.channels == 1:
            demand(verified['samples_compared'] == finite, 'compared', verified['samples_compared'], 'of', finite)
        info = self.json('info', name)
        demand(info['dims'] == list(self.dims), info['dims'])
        if not clamped and self.missing:
            demand(info['channels'][0]['missing'] == len(source) - finite, info['channels'][0]['missing'], 'missing')
        if self.abs:
            demand(verified['bound'] == {'abs': self.abs, 'held': True}, verified.get('bound'))
            demand(self.worst <= self.abs, 'off by', self.worst)
        if self.psnr and self.channels == 1:
            demand(verified['psnr'] is None or verified['psnr'] >= self.psnr, 'PSNR', verified['psnr'])  # null: no difference
        # 2 % of the range is what is kept unless something else is asked for.
        if self.data != 'labels' and not clamped:
            demand(self.worst <= .15 * self.peak, 'off by', self.worst, 'of', self.peak)

    def check_export(self, name):
        """Samples as they come out, from the file and from a file of another format made of it."""
        self.bcc4('export', name, '--all', '-o', 'e.nrrd', '--quiet')
        got, source, worst = self.exported('e.nrrd'), self.samples(), 0
        demand(len(got) == len(source), len(got), 'samples')
        for i, (g, s) in enumerate(zip(got, source)):
            if s != s and 'clamp' in self.args:
                continue
            demand((g != g) == (s != s), 'sample', i, 'is', g, 'of', s)
            worst = max(worst, abs(g - s)) if s == s else worst
        demand(worst <= self.exact * (1 + 1e-5) + 1e-5 * self.peak, 'export is off by', worst, ', verify tells', self.exact)
        if self.export == 'nrrd':
            return
        one = 'f.%04d.vdb' if self.export == 'vdb' else f'f.{self.export}'
        self.bcc4('export', name, '--all', '-o', one, '--quiet')
        back = ['--dt', .5] if self.export == 'vdb' else ['--dims', ','.join(map(str, self.dims)), '--dtype', self.kind, '--dt', .5] if self.export == 'raw' else []
        back += ['--on-nonfinite', 'hole'] if self.missing else []
        self.bcc4('import', one, *back, '--lattice', 'cc', '--exact', '--store', 'samples', '-o', 'back.bcc4', '--quiet')
        self.bcc4('export', 'back.bcc4', '--all', '-o', 'b.nrrd', '--quiet')
        # OpenVDB holds the sites that are stored, and beyond them air, without the ripples of the field there; nothing outside
        # the source's range, and nothing that is missing. It holds floats, which whole numbers are rounded from.
        vdb, present = self.export == 'vdb', [s for s in source if s == s]
        low, high = min(present), max(present)
        slack = .04 * self.peak + (.5 if self.dtype != 'f32' else 0) if vdb else 1e-4 * self.peak
        for i, (g, s) in enumerate(zip(self.whole_grid('b.nrrd', 'back.bcc4') if vdb else self.exported('b.nrrd'), got, strict=True)):
            s = min(max(s, low), high) if vdb and s == s else s
            demand(abs(g - s) <= slack or (s != s and (vdb or g != g)), self.export, 'comes back with', g, 'for', s, 'at sample', i)

    def exported(self, name):
        nrrd = Nrrd(os.path.join(self.folder, name))
        self.kind = {code: kind for kind, code in CODES.items()}[nrrd.values.typecode]
        return nrrd.values

    def whole_grid(self, name, source):
        """What is exported of a file from OpenVDB, which has the box of what is there, amid air."""
        begin = [int(n) for n in self.json('info', source)['attributes'].get('openvdb.begin', '0 0 0').split()]
        part, (nx, ny, nz) = self.exported(name), self.dims[:3]
        sizes = self.json('info', source)['dims']
        whole = [0.0] * (nx * ny * nz * sizes[3])
        for at, value in enumerate(part):
            x, y, z, t = (at // math.prod(sizes[:a]) % sizes[a] for a in range(4))
            whole[(((t * nz + z + begin[2]) * ny + y + begin[1]) * nx + x + begin[0])] = value
        return whole

    def check_places(self, name):
        """Values at samples, by their numbers, by their places in the world and in a slice."""
        t = min(4, self.frames - 1)
        some = [(1, 2, 0), (7, 6, self.dims[2] // 2), (9, 5, self.dims[2] // 2), (8, 8, self.dims[2] - 1), (12, 10, 0)]
        by_number = self.json('probe', name, '--index', '--time', t, *sum((['--at', ','.join(map(str, p))] for p in some), []))
        world = [[self.places(a)[p[a]] for a in range(3)] for p in some]
        by_place = self.json('probe', name, '--time', self.moments[t], *sum((['--at', ','.join(map(str, p))] for p in world), []))
        self.bcc4('slice', name, '--index', '--time', t, '-o', 's.nrrd', '--quiet', '--overwrite')
        cut = Nrrd(os.path.join(self.folder, 's.nrrd'))
        demand(list(cut.sizes[-3:]) >= list(self.dims[:3]), cut.sizes)
        slack = 1e-4 * self.peak + 1e-6 * 1000
        for n, p in enumerate(some):
            a, b = by_number[0]['values'][n], by_place[0]['values'][n]
            s = cut.values[(p[2] * cut.sizes[-2] + p[1]) * cut.sizes[-3] + p[0]]
            truth = self.value(*p, t)
            if a is None:
                demand(b is None and s != s and truth != truth, p, 'is missing,', b, s, truth)
                continue
            demand(truth != truth or abs(a - truth) <= self.worst + slack, p, 'is', a, 'of', truth)
            demand(b is not None and abs(a - b) <= slack, p, 'is', a, 'by number,', b, 'by place')
            demand(abs(a - s) <= slack, p, 'is', a, 'in a slice', s)

    def check_picture(self, name):
        """A picture against the slow reference, which knows no trails."""
        t = min(4, self.frames - 1)
        moment = [] if '--plane' in self.render else ['--index', '--time', t]
        go = ['render', name, *moment, *self.render, '--size', '24x20', '--quiet', '--overwrite', '--quality', 'fine']
        self.bcc4(*go, '-o', 'p.png')
        if '--trail' in self.render:
            return
        self.bcc4(*go, '--reference', '-o', 'r.png')
        fast, slow = (sum(sum(read_png(os.path.join(self.folder, n)), []), ()) for n in ('p.png', 'r.png'))
        rmse = math.sqrt(sum((a - b) ** 2 for a, b in zip(fast, slow)) / len(fast))
        # The look of labels jumps from one to the next, where the steps of the two are not the same.
        demand(rmse <= (24 if self.data == 'labels' else 8), 'off the reference by RMSE', rmse, 'of 255')


class Pairs(ToolTest):
    def ends_in(self, numbers):
        """What a case ends in, None where it is as it should be; and its exit code."""
        shutil.rmtree(self.folder)
        os.makedirs(self.folder)
        try:
            Case(numbers, self.folder).check()
        except Wrong as wrong:
            return str(wrong), 0
        except Ended as ended:
            return ended.text, ended.code
        return None, 0

    def test_those_that_go_together_are_true(self):
        found, without = cases(COUNTS, excludes, 3 if LONG else 2)
        if not LONG:
            self.assertEqual([name_of(case_of(*t)) for t in without], [], 'no case holds these')
        print(len(found), 'cases')
        for case in found:
            with self.subTest(name_of(case)):
                wrong, _ = self.ends_in(case)
                if wrong and not may_end_in(case, wrong):
                    least = reduced(case, self.fails)
                    self.fail(f'{name_of(least)}\n  {self.ends_in(least)[0]}\nfirst seen as {wrong}')

    def fails(self, case):
        said = allowed(case) and self.ends_in(case)[0]
        return said and not may_end_in(case, said)

    def test_those_that_do_not_end_in_their_sentence(self):
        for together, code, text in REFUSED:
            for group in groups_of(together):
                with self.subTest(name_of(case_of(*group))):
                    said, ended = self.ends_in(case_of(*group))
                    self.assertEqual(ended, code, said)
                    self.assertIn(text, said)

    def test_known_faults_are_still_there(self):
        for together, text, fault in KNOWN:
            for group in groups_of(together):
                with self.subTest(name_of(case_of(*group))):
                    said, _ = self.ends_in(case_of(*group))
                    self.assertIn(text, said or '', f'it is mended: remove the row "{fault}"')


if __name__ == '__main__':
    main()
