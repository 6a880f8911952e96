"""bcc4 view: a page and a file, served to the browser on this machine."""
import concurrent.futures
import http.client
import os
import random
import re
import signal
import socket
import subprocess
import time

from harness import BCC4, ToolTest, main

DIMS = (8, 7, 6, 5)
PATIENCE = 5  # seconds for the head of a request: http_server.cpp
MOST = 400  # connections


class View(ToolTest):
    def setUp(self):
        super().setUp()
        self.volume(DIMS, lambda x, y, z, t: x + y * z + t, '--quiet', name='a file.bcc4')
        with open(self.path('a file.bcc4'), 'rb') as file:
            self.whole = file.read()
        os.makedirs(self.path('page'))
        self.write('page/index.html', b'<title>page</title>'), self.write('page/core.wasm', b'\0asm'), self.write('secret', b'no')
        self.write('page/empty', b'')

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
        link.request(method, path, headers={name.replace('_', '-'): value for name, value in headers.items()})
        answer = link.getresponse()
        body = answer.read()
        link.close()
        return answer.status, body, answer.headers

    def raw(self, port, request):
        """What is answered to these bytes, up to the end of the connection, be it in the middle of them."""
        answer = b''
        try:
            with socket.create_connection(('127.0.0.1', port), timeout=20) as link:
                link.sendall(request)
                while got := link.recv(1 << 16):
                    answer += got
        except ConnectionError:
            pass
        return answer

    def is_well(self, server, port):
        self.assertIsNone(server.poll())
        self.assertEqual(self.get(port, '/core.wasm')[:2], (200, b'\0asm'))

    def told(self, server, name):
        """A number of the server's process, as /proc tells it."""
        with open(f'/proc/{server.pid}/status') as file:
            return int(re.search(rf'^{name}:\s*(\d+)', file.read(), re.M)[1])

    def test_page_and_file(self):
        server, port = self.serve()
        status, body, headers = self.get(port, '/?url=file.bcc4')
        self.assertEqual((status, body, headers['Content-Type']), (200, b'<title>page</title>', 'text/html; charset=utf-8'))
        self.assertEqual(self.get(port, '/core.wasm')[2]['Content-Type'], 'application/wasm')
        self.assertEqual(self.get(port, '/file.bcc4')[1], self.whole)
        self.assertEqual(self.get(port, '/empty')[:2], (200, b''))
        status, body, headers = self.get(port, '/file.bcc4', method='HEAD')
        self.assertEqual((status, body, headers['Content-Length']), (200, b'', str(len(self.whole))))
        with open(self.path('a file.bcc4'), 'ab') as file:  # one that is still written
            file.write(b'more')
        self.assertEqual(self.get(port, '/file.bcc4', Range='bytes=-6')[1], self.whole[-2:] + b'more')
        server.send_signal(signal.SIGINT)
        self.assertEqual(server.wait(20), 0)

    def test_ranges(self):
        _, port = self.serve()
        whole, size = self.whole, len(self.whole)
        far = 10 ** 25  # more than 64 bits hold
        for asked, first, last in (('10-29', 10, 29), ('0-0', 0, 0), ('-7', size - 7, size - 1), (f'-{far}', 0, size - 1),
                                   ('100-', 100, size - 1), (f'{size - 1}-{size + 5}', size - 1, size - 1),
                                   (f'5-{far}', 5, size - 1)):
            status, body, headers = self.get(port, '/file.bcc4', Range='bytes=' + asked)
            self.assertEqual((status, body), (206, whole[first:last + 1]), asked)
            self.assertEqual(headers['Content-Range'], f'bytes {first}-{last}/{size}', asked)
            self.assertEqual(headers['Content-Length'], str(len(body)), asked)
        for asked in (f'{size}-', f'{size}-{size + 9}', '-0', f'{far}-', f'{far}-{far}'):
            status, _, headers = self.get(port, '/file.bcc4', Range='bytes=' + asked)
            self.assertEqual((status, headers['Content-Range']), (416, f'bytes */{size}'), asked)
        # No ranges, or several: those are left out of account.
        for asked in ('bytes=abc-10', 'bytes=10-abc', 'bytes=0-1,5-6', 'bytes=0-1,', 'bytes=5-2', 'bytes=-', 'bytes=', 'bytes=--5',
                      'bytes=-5-', 'bytes=+1-5', 'bytes=1', 'bytes= 1-5', 'bytes=0x1-5', 'lines=1-5', 'bytes 1-5', '1-5', '-'):
            status, body, headers = self.get(port, '/file.bcc4', Range=asked)
            self.assertEqual((status, len(body), headers['Content-Range']), (200, size, None), asked)
            self.assertEqual(body, whole, asked)
        self.assertEqual(self.get(port, '/file.bcc4', Range='Bytes=1-5')[:2], (206, whole[1:6]))
        self.assertEqual(self.get(port, '/file.bcc4', Range='bytes=1-5', If_Range='"a"')[:2], (200, whole))
        status, _, headers = self.get(port, '/file.bcc4', method='HEAD', Range='bytes=1-5')
        self.assertEqual((status, headers['Content-Length']), (200, str(size)))
        self.assertEqual(self.get(port, '/empty', Range='bytes=0-')[0], 416)

    def test_nothing_else_is_given(self):
        _, port = self.serve()
        os.mkfifo(self.path('page/pipe'))
        for path in ('/../secret', '/%2e%2e/secret', '/..%2fsecret', '/nothing', '/.hidden', '//secret', '/pipe', '/..'):
            self.assertEqual(self.get(port, path)[0], 404, path)
        for method in ('POST', 'PUT', 'DELETE', 'OPTIONS', 'TRACE', 'get'):
            status, _, headers = self.get(port, '/', method=method)
            self.assertEqual((status, headers['Allow']), (405, 'GET, HEAD'), method)

    def test_only_this_machine_is_answered(self):
        """Pages of other sites, whose name was led to 127.0.0.1, get nothing; nor is there another address."""
        server, port = self.serve()
        for host in (f'127.0.0.1:{port}', f'localhost:{port}', f'LocalHost:{port}'):
            self.assertEqual(self.get(port, '/', Host=host)[0], 200, host)
        for host in ('evil.example', f'evil.example:{port}', '127.0.0.1', 'localhost', f'localhost:{port % 65535 + 1}',
                     f'127.0.0.1.evil.example:{port}', f'localhost.evil.example:{port}', f'evil.example#localhost:{port}',
                     f'127.0.0.2:{port}', f'localhost:{port}0', f'localhost:0{port}', f'[::1]:{port}', f'0.0.0.0:{port}', ''):
            for path in ('/', '/file.bcc4', '/nothing'):
                status, body, _ = self.get(port, path, Host=host)
                self.assertEqual(status, 403, host)
                self.assertNotIn(b'title', body)
        self.assertNotIn(b'title', self.raw(port, b'GET / HTTP/1.1\r\n\r\n'))  # without any
        self.assertNotIn(b'title', self.raw(port, b'GET / HTTP/1.0\r\n\r\n'))
        sockets = {os.readlink(f'/proc/{server.pid}/fd/{n}') for n in os.listdir(f'/proc/{server.pid}/fd')}
        listens = []
        for kind in ('tcp', 'tcp6', 'udp', 'udp6'):
            if os.path.exists(f'/proc/net/{kind}'):
                with open(f'/proc/net/{kind}') as file:
                    rows = [line.split() for line in file.readlines()[1:]]
                listens += [(kind, row[1]) for row in rows if f'socket:[{row[9]}]' in sockets and row[3] == '0A']
                listens += [(kind, row[1]) for row in rows if f'socket:[{row[9]}]' in sockets and kind.startswith('udp')]
        self.assertEqual(listens, [('tcp', f'0100007F:{port:04X}')])

    def test_no_request_ends_it(self):
        server, port = self.serve()
        here = b'Host: 127.0.0.1:%d\r\n' % port
        requests = [b'GET ?x HTTP/1.1\r\n' + here + b'\r\n', b'GET  HTTP/1.1\r\n' + here + b'\r\n', b'GET', b'\r\n\r\n', b'\0' * 100,
                    b'GET / HTTP/9.9\r\n' + here + b'\r\n', b'GET http://evil.example/ HTTP/1.1\r\n' + here + b'\r\n',
                    b'GET /%00%ff%zz% HTTP/1.1\r\n' + here + b'\r\n', b'GET /' + b'%2e' * 5000 + b' HTTP/1.1\r\n' + here + b'\r\n',
                    b'POST / HTTP/1.1\r\n' + here + b'Content-Length: 99999999999999999999\r\n\r\n' + b'x' * 100000,
                    b'POST / HTTP/1.1\r\n' + here + b'Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n' + b'x' * 100000,
                    b'GET / HTTP/1.1\r\n' + here + b'Range: bytes=' + b'0-0,' * 5000 + b'\r\n\r\n']
        # A few hundred requests, with bytes changed, cut out, doubled, or put in.
        chance = random.Random(24)
        good = [b'GET /file.bcc4 HTTP/1.1\r\n' + here + b'Range: bytes=10-29\r\n\r\n',
                b'HEAD /core.wasm?a=b HTTP/1.1\r\n' + here + b'Accept: */*\r\nIf-Range: "a"\r\n\r\n',
                b'POST / HTTP/1.1\r\n' + here + b'Transfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n0\r\n\r\n']
        special = [b'\0', b'\r', b'\n', b'\r\n', b' ', b'\t', b':', b'%', b'?', b'/', b'\xff', b'-', b',', b'9' * 30]
        for _ in range(400):
            request = bytearray(chance.choice(good))
            for _ in range(chance.randint(1, 8)):
                at = chance.randrange(len(request) + 1)
                some = chance.choice([b'', bytes([chance.randrange(256)]), chance.choice(special), bytes(request[at:at + 9]) * 2])
                request[at:at + chance.randrange(3)] = some
            requests.append(bytes(request))
        with concurrent.futures.ThreadPoolExecutor(200) as many:  # one without an end is answered after some seconds
            for request, answer in zip(requests, many.map(lambda request: self.raw(port, request), requests)):
                self.assertTrue(not answer or re.match(rb'HTTP/1\.[01] [2345]\d\d ', answer), (request[:300], answer[:100]))
        self.is_well(server, port)
        before = self.told(server, 'VmRSS')
        self.raw(port, b'GET /' + b'a' * (64 << 20))
        self.raw(port, b'GET / HTTP/1.1\r\n' + b'a: b\r\n' * (8 << 20))
        self.assertLess(self.told(server, 'VmRSS') - before, 8 << 10, 'kB of a head without an end')
        self.is_well(server, port)

    def test_clients_that_say_nothing(self):
        """They hold no threads, honest ones are answered meanwhile, and in the end they are hung up on."""
        server, port = self.serve()
        silent = []
        self.addCleanup(lambda: [link.close() for link in silent])
        silent += [socket.create_connection(('127.0.0.1', port), timeout=20) for _ in range(200)]
        start = time.monotonic()
        self.is_well(server, port)
        self.assertLess(time.monotonic() - start, PATIENCE / 2)
        self.assertLess(self.told(server, 'Threads'), 10)
        # More than it takes, of which one says a little from time to time.
        silent += [socket.create_connection(('127.0.0.1', port), timeout=20) for _ in range(MOST - 200 + 20)]
        slow = silent[100]
        slow.sendall(b'GET / HTTP/1.1\r\na: ')
        start = time.monotonic()
        while time.monotonic() - start < 3 * PATIENCE:
            try:
                slow.sendall(b'b')
            except ConnectionError:
                break
            time.sleep(0.2)
        self.assertLess(time.monotonic() - start, 2 * PATIENCE)
        start = time.monotonic()
        self.is_well(server, port)
        self.assertLess(time.monotonic() - start, 2 * PATIENCE)
        self.assertEqual(silent[0].recv(1), b'')
        self.assertEqual(silent[199].recv(1), b'')

    def test_what_is_wrong_is_said_first(self):
        _, text = self.bcc4('view', 'a file.bcc4', '--page', 'nowhere', expect=3)
        self.assertIn('examples/web/build.sh', text)
        self.bcc4('view', 'a file.bcc4.raw', '--page', 'page', expect=3)
        self.bcc4('view', expect=2)
        _, port = self.serve()
        self.refused(3, f'port {port} of 127.0.0.1', 'view', 'a file.bcc4', '--page', 'page', '--port', port)


main()
