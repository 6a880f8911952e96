"""bcc4 help: every command says what it does in a sentence, and the examples that it shows work as they are."""
import os
import re
import shlex
import shutil
import subprocess

from harness import BCC4, ToolTest, field, main

DIMS = (64, 64, 64, 4)
NEEDED = ('import', 'info', 'probe', 'verify', 'export', 'slice', 'render', 'concat', 'compare', 'help')  # in an order in which they can follow each other
WIDTH = 100


def printed(*args):
    return subprocess.run([BCC4, *args], capture_output=True, text=True, check=True).stdout


def examples(page):
    return re.findall(r'^  (bcc4 .*)$', page.split('Examples:\n')[1].split('\n\n')[0], re.M)


class Help(ToolTest):
    def puff(self, t):
        def value(x, y, z):
            return max(0, 1 - ((x - 28 - 2 * t) ** 2 + (y - 32) ** 2 + (z - 30) ** 2) / 400)
        with open(self.path(f'smoke.{t:04d}.raw'), 'wb') as f:
            field(DIMS[:3] + (1,), lambda x, y, z, _: value(x, y, z), 'f').tofile(f)

    def test_every_command_has_a_page_and_its_examples_work(self):
        for t in range(DIMS[3]):
            self.puff(t)
        self.write('places.csv', b'x,y,z\n28,32,30\n12.5,14,9\n')
        for name in ('ct.bcc4', 'organs.bcc4'):
            self.bcc4('import', 'smoke.0000.raw', '--dims', ','.join(map(str, DIMS[:3])), '--dtype', 'f32', '-o', name, '--quiet')
        listed = re.findall(r'^  (\w+)  ', printed('help').split('Subcommands:')[1], re.M)
        self.assertEqual(set(listed), set(NEEDED) | {'completion', 'manual', 'view'})
        for command in NEEDED:
            page = printed('help', command)
            self.assertEqual(page, printed(command, '--help'))
            shown = examples(page)
            self.assertTrue(shown, command)
            for line in shown:
                words = shlex.split(line)[1:]
                if words[-1].endswith('.mp4') and not shutil.which('ffmpeg'):
                    continue
                spread = [name for w in words for name in (self.files(w) if '*' in w else [w])]
                self.bcc4(*spread)
                if '-o' in words:
                    self.assertGreater(os.path.getsize(self.path(words[words.index('-o') + 1])), 0, line)

    def files(self, pattern):
        names = sorted(n for n in os.listdir(self.path('.')) if re.fullmatch(pattern.replace('.', r'\.').replace('*', '.*'), n))
        self.assertTrue(names)
        return names

    def test_lines_fit_a_terminal(self):
        for command in NEEDED:
            for page in (printed('help', command), printed('help', command, 'all')):
                for line in page.splitlines():
                    self.assertLessEqual(len(line), WIDTH, (command, line))

    def test_import_begins_with_what_is_needed_first(self):
        """Its page has two screens and names all other options by topics, whose pages are parts of that of all."""
        page, everything = printed('help', 'import'), printed('help', 'import', 'all')
        self.assertLessEqual(len(page.splitlines()), 56)
        self.assertEqual(everything, printed('import', '--help-all'))
        first, more = page.split('\nMore, by bcc4 help import TOPIC, or all:\n')
        defined = lambda text: set(re.findall(r'^  (?:-\w,)?(--[\w-]+)', text, re.M))
        topics = re.findall(r'^    (\w+)  ', more, re.M)
        self.assertEqual(topics, ['input', 'values', 'lattice', 'parts'])
        named = []
        for topic in topics:
            told = printed('help', 'import', topic)
            self.assertIn(told.strip('\n'), everything)
            named += defined(told)
        self.assertEqual(sorted(named), sorted(re.findall(r'(?<= )--[\w-]+', more)))
        self.assertEqual(sorted([*named, *defined(first)]), sorted(defined(everything)))
        for option in ('--dims', '--dtype', '--dt', '--output', '--psnr', '--dry-run'):
            self.assertIn(option, defined(first))
        for words, said in ((('import', 'latice'), 'did you mean lattice?'), (('info', 'lattice'), 'there are all')):
            self.assertIn(said, self.bcc4('help', *words, expect=2)[1])

    def test_options_of_render_stand_under_headings(self):
        """Each heading once, in this order, with the options that belong there; the manual has them as well."""
        page = printed('help', 'render')
        wanted = {'The moment or plane': '--plane', 'Pictures and films': '--seconds', 'The view': '--zoom',
                  'Colours and surfaces': '--iso', 'Beside the channel': '--with', 'Trails: what moved': '--trail-mode',
                  'Background and annotation': '--annotate', 'Quality and light': '--step',
                  "With other programs' pictures": '--deep', 'The work': '--threads'}
        found = re.findall(r'^(\S.*):$', page.split('Options:\n')[1], re.M)
        self.assertEqual(found, list(wanted))
        for heading, option in wanted.items():
            section = re.split(r'^\S.*:$', page.split(f'\n{heading}:\n')[1], maxsplit=1, flags=re.M)[0]
            self.assertIn(f'  {option} ', section, heading)
            self.assertIn(f'\n{heading}:\n', printed('manual').replace('\\-', '-'))

    def test_unknown_commands_are_named(self):
        for words in (('help', 'slic'), ('slic',)):
            _, said = self.bcc4(*words, expect=2)
            self.assertIn('did you mean slice?', said)
        # A second command's name is an argument.
        done = subprocess.run([BCC4, 'slice', 'import', '--time', '1', '-o', 'x.nrrd'], capture_output=True, text=True)
        self.assertIn('import: cannot open', done.stderr)
        self.assertIn('Examples:', printed('help'))

    def test_the_manual_shows_the_examples(self):
        page = printed('manual').replace('\\-', '-')
        for command in NEEDED:
            for line in examples(printed('help', command)):
                self.assertIn(line, page)


if __name__ == '__main__':
    main()
