#!/usr/bin/env python3
"""mutants_test FOLDER: faults written into a small program, which is compiled once, are dormant until they are asked for."""
import os
import subprocess
import sys
import unittest

from faults import blank, faults_of
from mutants import header, place_all, rewritten

SOURCE = r'''// a + b, not code
#include <algorithm>
#include <array>
#include <cstdio>
#include <initializer_list>
namespace {
constexpr int two = 1 + 1;
int sum = 0;
void add(int n) { sum += n; }
int turned(bool yes) {
  if (!yes) return 1;
  return 0;
}
}  // namespace
int main() {
  std::array<int, two> at = {5, 7};
  const int spread = at[1] -
                     3;  // - 1
  for (int i = 0; i < 2; ++i) add(at[0]);
  if (spread > 0)
    add(100);
  else
    add(1);
  int product = two == 2 ? spread * at[1] : 0;
  product += std::max(product, 20);
  std::printf("%d %d %d %d a + b\n", sum, spread, product, turned(spread != 4 && product > 0));
}
'''
# Line, what stands there instead, and what the program says then.
FAULTS = [(9, ' -= ', '-110 4 56 1'), (11, '', '110 4 56 0'), (17, '[0]', '110 2 34 0'), (19, '1; ', '105 4 56 1'),
          (20, ' <= ', '11 4 56 1'), (21, '  ;', '10 4 56 1'), (23, '  ;', '110 4 56 1'), (24, ' / ', '110 4 20 1'),
          (25, ' -= ', '110 4 0 1'), (26, ' || ', '110 4 56 0')]
SOUND = '110 4 56 1'
NOT_REACHED = 7
FOLDER = sys.argv.pop(1)


def write(name, text):
    path = os.path.join(FOLDER, name)
    with open(path, 'w', encoding='utf-8') as f:
        f.write(text)
    return path


class MutantsTest(unittest.TestCase):
    def setUp(self):
        os.makedirs(FOLDER, exist_ok=True)
        self.faults = list(faults_of('src/room/x.cpp', SOURCE))

    def one(self, line, instead):
        return next(f for f in self.faults if (f.line, f.instead) == (line, instead))

    def test_what_the_compiler_has_to_know_and_what_is_no_code_is_left_alone(self):
        self.assertFalse([f for f in self.faults if f.line in (1, 7)])
        self.assertFalse([f for f in self.faults if 'printf' in f.before and f.kind == 'sign'])

    def test_a_line_holds_one_fault(self):
        placed, without = place_all(blank(SOURCE, True), [self.one(25, 'std::min'), self.one(25, ' -= ')])
        self.assertEqual([f.instead for f, _ in placed], ['std::min'])
        self.assertEqual(without, [])

    def test_one_program_holds_all_and_each_wakes_alone(self):
        placed, _ = place_all(blank(SOURCE, True), [self.one(line, instead) for line, instead, _ in FAULTS])
        self.assertEqual(len(placed), len(FAULTS))
        head = write('mutant.h', header(len(FAULTS)))
        numbered = [(n, *p) for n, p in enumerate(placed, 1)]
        source = write('x.cpp', rewritten(SOURCE, blank(SOURCE, False), numbered, head))
        program = os.path.join(FOLDER, 'x')
        subprocess.run(['c++', '-std=c++20', '-Wall', '-Wextra', '-Wconversion', '-Wshadow', '-Werror', source, '-o', program],
                       check=True)
        told = write('reached', '')
        for n, (_, _, expected) in enumerate([(0, '', SOUND), *FAULTS]):
            said = subprocess.run([program], env=dict(os.environ, BCCSPLAT_MUTANT=str(n), BCCSPLAT_MUTANTS_REACHED=told),
                                  capture_output=True, text=True, check=True).stdout
            self.assertEqual(said, expected + ' a + b\n', n)
            if n == 0:
                with open(told, encoding='utf-8') as f:
                    reached = {int(line) for line in f}
                self.assertEqual(reached, set(range(1, len(FAULTS) + 1)) - {NOT_REACHED})


if __name__ == '__main__':
    unittest.main()
