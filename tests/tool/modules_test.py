"""OpenVDB, NetCDF and others are loaded where they are needed: the tool starts without, and says what is missing or damaged."""
import os
import shutil
import subprocess

import harness
from harness import BCC4, ToolTest, has_reader, main

VDB = b'\x20\x42\x44\x56\0\0\0\0'
MODULES = {'openvdb': ('OpenVDB', 'a.vdb', VDB + b'\xff' * 100), 'netcdf': ('NetCDF', 'a.nc', b'CDF\x01' + bytes(10))}


class Modules(ToolTest):
    def setUp(self):
        super().setUp()
        self.readers = [r for r in MODULES if has_reader(r)]
        for _, name, content in MODULES.values():
            self.write(name, content)

    def use(self, program):
        """The tool of this test from here on."""
        self.addCleanup(setattr, harness, 'BCC4', BCC4)
        harness.BCC4 = program

    def copied(self, change=None):
        """The tool alone in a folder, with modules beside it that `change` was done to."""
        shutil.copy(BCC4, self.path('bcc4'))
        for reader in self.readers if change else []:
            with open(os.path.join(os.path.dirname(BCC4), f'bcc4_{reader}.so'), 'rb') as f:
                self.write(f'bcc4_{reader}.so', change(f.read()))
        self.use(self.path('bcc4'))

    def test_the_tool_starts_without_their_libraries(self):
        needed = subprocess.run(['ldd', BCC4], capture_output=True, text=True, check=True).stdout
        self.assertIn('libbccsplat', needed)
        for library in ('openvdb', 'tbb', 'netcdf', 'hdf5', 'curl', 'tiff', 'microhttpd', 'gnutls'):
            self.assertNotIn('lib' + library, needed)

    def test_errors_are_those_of_the_readers(self):
        for reader, text in (('openvdb', 'a.vdb: holds no grids'), ('netcdf', 'a.nc: 14 bytes cannot hold')):
            if reader in self.readers:
                self.refused(3, text, 'import', MODULES[reader][1], '-o', 'x.bcc4', output='x.bcc4')
                self.refused(2, '--dims', 'import', MODULES[reader][1], '--dims', '1,1,1', '-o', 'x.bcc4', output='x.bcc4')

    def test_a_missing_module_is_named(self):
        self.copied()
        self.bcc4('--version')
        for reader in self.readers:
            library, name, _ = MODULES[reader]
            self.refused(3, f'this bcc4 was built with {library}, but its module', 'import', name, '-o', 'x.bcc4', output='x.bcc4')
            self.refused(3, f'bcc4_{reader}.so cannot be opened', 'import', name, '-o', 'x.bcc4', output='x.bcc4')
        v = self.volume((4, 4, 4, 1), lambda x, y, z, t: x + y + z, name='t.bcc4')
        self.refused(3, 'bcc4_tiff.so cannot be opened', 'export', v, '--all', '-o', 'x.tif', output='x.tif')
        if 'netcdf' in self.readers:
            self.refused(3, 'bcc4_netcdf.so cannot be opened', 'export', v, '--all', '-o', 'x.nc', output='x.nc')
        if 'openvdb' in self.readers:
            v = self.volume((4, 4, 4, 1), lambda x, y, z, t: x + y + z)
            self.refused(3, 'bcc4_openvdb.so cannot be opened', 'export', v, '--all', '-o', 'x.vdb', output='x.vdb')
            self.refused(3, 'bcc4_openvdb.so cannot be opened', 'slice', v, '--time', '0', '-o', 'x.vdb', output='x.vdb')
        if os.path.exists(os.path.join(os.path.dirname(BCC4), 'bcc4_microhttpd.so')):
            self.write('core.wasm', b'')
            self.refused(3, 'bcc4_microhttpd.so cannot be opened', 'view', v, '--page', '.')

    def test_a_module_of_another_build_is_refused(self):
        self.copied(lambda module: module.replace(b'bcc4_module_', b'bcc4_Module_'))
        for reader in self.readers:
            self.refused(3, f'bcc4_{reader}.so is of another build', 'import', MODULES[reader][1], '-o', 'x.bcc4')

    def test_a_damaged_module_is_refused(self):
        self.copied(lambda module: b'no module' * 100)
        for reader in self.readers:
            self.refused(3, f'bcc4_{reader}.so cannot be opened', 'import', MODULES[reader][1], '-o', 'x.bcc4')

    def test_modules_beside_the_tool_are_found(self):
        self.copied(lambda module: module)
        if 'openvdb' in self.readers:
            v = self.volume((4, 4, 4, 1), lambda x, y, z, t: x + y + z)
            self.bcc4('export', v, '--all', '-o', 'x.vdb')


if __name__ == '__main__':
    main()
