"""bcc4 view: a page and a file, served to the browser on this machine."""
import http.client
import os
import re
import signal
import subprocess

from harness import BCC4, ToolTest, field, main

DIMS = (8, 7, 6, 5)


class View(ToolTest):
    def setUp(self):
        super().setUp()
        self.volume(DIMS, lambda x, y, z, t: x + y * z + t, '--quiet', name='a file.bcc4')
        os.makedirs(self.path('page'))
        self.write('page/index.html', b'<title>page</title>'), self.write('page/core.wasm', b'\0asm'), self.write('secret', b'no')

    def serve(self):
        server = subprocess.Popen([BCC4, 'view', 'a file.bcc4', '--page', 'page'], cwd=self.folder, stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(lambda: (server.kill(), server.wait(), server.stdout.close()))
        link = server.stdout.readline()
        found = re.fullmatch(r'http://127\.0\.0\.1:(\d+)/\?url=file\.bcc4\n', link)
        self.assertTrue(found, link)
        return server, int(found[1])

    def get(self, port, path, method='GET', **headers):
        link = http.client.HTTPConnection('127.0.0.1', port, timeout=20)
        link.request(method, path, headers=headers)
        answer = link.getresponse()
        body = answer.read()
        link.close()
        return answer.status, body, answer.headers

    def test_page_and_ranges_of_the_file(self):
        server, port = self.serve()
        status, body, headers = self.get(port, '/?url=file.bcc4')
        self.assertEqual((status, body, headers['Content-Type']), (200, b'<title>page</title>', 'text/html; charset=utf-8'))
        self.assertEqual(self.get(port, '/core.wasm')[2]['Content-Type'], 'application/wasm')
        with open(os.path.join(self.folder, 'a file.bcc4'), 'rb') as file:
            whole = file.read()
        self.assertEqual(self.get(port, '/file.bcc4')[1], whole)
        status, body, headers = self.get(port, '/file.bcc4', Range='bytes=10-29')
        self.assertEqual((status, body), (206, whole[10:30]))
        self.assertEqual(headers['Content-Range'], f'bytes 10-29/{len(whole)}')
        self.assertEqual(self.get(port, '/file.bcc4', Range='bytes=-7')[1], whole[-7:])
        self.assertEqual(self.get(port, '/file.bcc4', Range=f'bytes={len(whole)}-')[0], 416)
        status, body, headers = self.get(port, '/file.bcc4', method='HEAD')
        self.assertEqual((status, body, headers['Content-Length']), (200, b'', str(len(whole))))
        server.send_signal(signal.SIGINT)
        server.wait(20)

    def test_nothing_else_is_given(self):
        _, port = self.serve()
        for path in ('/../secret', '/%2e%2e/secret', '/..%2fsecret', '/nothing', '/.hidden'):
            self.assertEqual(self.get(port, path)[0], 404, path)
        self.assertEqual(self.get(port, '/', method='POST')[0], 405)

    def test_what_is_wrong_is_said_first(self):
        _, text = self.bcc4('view', 'a file.bcc4', '--page', 'nowhere', expect=3)
        self.assertIn('examples/web/build.sh', text)
        self.bcc4('view', 'a file.bcc4.raw', '--page', 'page', expect=3)
        self.bcc4('view', expect=2)


main()
