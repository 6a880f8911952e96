"""bcc4 manual and bcc4 completion know every command and option that --help knows."""
import re
import shutil
import subprocess
import unittest

from harness import BCC4, ToolTest, main


def printed(*args):
    return subprocess.run([BCC4, *args], capture_output=True, text=True, check=True).stdout


def commands():
    listed = printed('--help').split('Subcommands:')[1]
    return re.findall(r'^  (\w+) ', listed, re.M)


def options(command):
    return set(re.findall(r'(?<![\w-])--[a-z][a-z0-9-]*', '\n'.join(
        line[:40].split('   ')[0] for line in printed('help', command, 'all').splitlines() if line.startswith('  -'))))


class Manual(ToolTest):
    def test_names_every_option(self):
        page = printed('manual').replace('\\-', '-')
        scripts = [printed('completion', shell) for shell in ('bash', 'zsh', 'fish')]
        self.assertIn('render', commands())
        for command in commands():
            self.assertIn(f'.SS {command}\n', page)
            for option in options(command):
                self.assertIn(option, page.split(f'.SS {command}\n')[1].split('\n.SS ')[0], command)
                for script in scripts[:2]:
                    self.assertIn(option, script)
                self.assertIn(f'-l {option[2:]} ', scripts[2])
        self.assertIn('--quality', options('render'))

    @unittest.skipUnless(shutil.which('groff'), 'groff is not here')
    def test_page_is_sound_roff(self):
        done = subprocess.run(['groff', '-man', '-Tutf8', '-ww', '-z'], input=printed('manual'), capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ''))

    def complete(self, *words):
        script = printed('completion', 'bash') + f'''
COMP_WORDS=({' '.join(f"'{w}'" for w in words)}); COMP_CWORD={len(words) - 1}
_bcc4; printf '%s\\n' "${{COMPREPLY[@]}}"'''
        return subprocess.run(['bash', '-c', script], capture_output=True, text=True, check=True,
                              cwd=self.path('.')).stdout.split()

    def test_bash_completes_commands_options_choices_and_files(self):
        self.assertEqual(self.complete('bcc4', 'rend'), ['render'])
        self.assertEqual(self.complete('bcc4', 'render', '--unit'), ['--unit-distance'])
        self.assertEqual(set(self.complete('bcc4', 'render', '--quality', '')), {'draft', 'normal', 'fine', 'best'})
        open(self.path('smoke.bcc4'), 'w').close()
        self.assertEqual(self.complete('bcc4', 'info', 'smo'), ['smoke.bcc4'])

    def test_other_shells_are_named(self):
        done = subprocess.run([BCC4, 'completion', 'tcsh'], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn('bash, zsh or fish', done.stderr)


main()
