"""Dates and calendars: from NetCDF through the file to info, pictures and back."""
import os
import unittest

from harness import DATA, ToolTest, field, main


class Dates(ToolTest):
    def make(self, epoch, calendar, unit, times='0.5 1.5 2.5 3.5'):
        head = ('NRRD0005\ntype: float\ndimension: 4\nspace dimension: 3\nsizes: 5 4 3 4\n'
                'space directions: (1,0,0) (0,1,0) (0,0,1) none\nspace origin: (0,0,0)\nkinds: domain domain domain time\n'
                f'units: "" "" "" "{unit}"\nendian: little\nencoding: raw\naxis 3 index type:=numeric\n'
                f'axis 3 index values:={times}\ntime epoch:={epoch}\ntime calendar:={calendar}\n\n')
        self.write('a.nrrd', head.encode() + field((5, 4, 3, 4), lambda x, y, z, t: x + t, 'f').tobytes())
        self.bcc4('import', 'a.nrrd', '-o', 'a.bcc4', '--quiet', '--overwrite')

    def test_info_has_dates(self):
        for epoch, calendar, unit, first, last in (
                ('2000-02-27', 'noleap', 'days', '2000-02-27 12:00', '2000-03-02 12:00'),
                ('2000-02-27', '', 'days', '2000-02-27 12:00', '2000-03-01 12:00'),
                ('1960-01-01', '360_day', 'months', '1960-01-16 00:00', '1960-04-16 00:00')):
            self.make(epoch, calendar, unit)
            dates = self.json('info', 'a.bcc4')['times']['dates']
            self.assertEqual((dates['first'], dates['last'], dates['calendar']), (first, last, calendar or 'standard'))
            out, _ = self.bcc4('info', 'a.bcc4', '--frames')
            self.assertIn(f'{first} to {last}', out)
            self.assertIn(f'3 at 3.5, {last}: ', out)
            # NRRD has them, too.
            self.bcc4('export', 'a.bcc4', '--all', '-o', 'b.nrrd', '--overwrite', '--quiet')
            self.bcc4('import', 'b.nrrd', '-o', 'b.bcc4', '--overwrite', '--quiet')
            self.assertEqual(self.json('info', 'b.bcc4')['times'], self.json('info', 'a.bcc4')['times'])

    def test_no_dates_without_an_epoch_or_a_known_unit(self):
        for epoch, unit in (('soon', 'days'), ('2000-01-01', 'furlongs')):
            self.make(epoch, '', unit)
            self.assertNotIn('dates', self.json('info', 'a.bcc4')['times'])
            self.assertNotIn('dates', self.bcc4('info', 'a.bcc4')[0])

    def test_a_step_keeps_the_first_date(self):
        self.make('1960-01-01', '', 'days', times='3653 3653.5 3655 3656')
        for frames, first, last in ((), '1970-01-01 00:00', '1970-01-02 12:00'), (('--frames', '2-3'), '1970-01-03 00:00', '1970-01-03 12:00'):
            said, _ = self.bcc4('import', 'a.nrrd', '--dt', .5, *frames, '-o', 'a.bcc4', '--overwrite')
            dates = self.json('info', 'a.bcc4')['times']['dates']
            self.assertEqual((dates['first'], dates['last']), (first, last))
            self.assertIn('--dt 0.5, from 365', said)
            self.bcc4('verify', 'a.bcc4', '--against', 'a.nrrd')

    def test_pictures_show_them(self):
        if 'without text' in self.bcc4('--version')[0]:
            self.skipTest('no letters in this build')
        pictures = []
        for calendar in ('noleap', 'standard', 'standard'):
            self.make('2000-02-27', calendar, 'days')
            self.bcc4('render', 'a.bcc4', '--time', 2.5, '--annotate', 'time', '--size', 200, '-o', 'p.png', '--quiet')
            with open(self.path('p.png'), 'rb') as f:
                pictures.append(f.read())
        self.assertNotEqual(pictures[0], pictures[1])  # 1 March and 29 February
        self.assertEqual(pictures[1], pictures[2])

    @unittest.skipUnless(os.path.exists(os.path.join(DATA, 'cases')), 'no shared cases')
    def test_cases(self):
        for name, first, calendar in (('days_noleap.nc', '2000-02-27 12:00', 'noleap'), ('months_calendar_360.nc', '1960-01-16 00:00', '360')):
            self.bcc4('import', os.path.join(DATA, 'cases', name), '-o', 'c.bcc4', '--overwrite', '--quiet')
            a = self.json('info', 'c.bcc4')
            self.assertEqual((a['times']['dates']['first'], a['times']['dates']['calendar']), (first, calendar))
            self.bcc4('export', 'c.bcc4', '--all', '-o', 'c.nc', '--overwrite', '--quiet')
            self.bcc4('import', 'c.nc', '-o', 'd.bcc4', '--overwrite', '--quiet')
            self.assertEqual(self.json('info', 'd.bcc4')['times'], a['times'])


if __name__ == '__main__':
    main()
