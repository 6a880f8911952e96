"""A simulation on eight ranks writes the file of one rank; a rank that fails or dies leaves no file, and a second run goes on."""
import os
import shutil
import signal
import subprocess
import sys
import time

EXAMPLES, FOLDER = sys.argv[2], sys.argv[3]
PROGRAM = os.path.join(EXAMPLES, 'mpi_insitu')
SIZE = '64,48,56,9'
RANKS = 8


def run(ranks, *args, largest_file=None):
    """Starts the ranks; largest_file: KiB that a file of theirs may have, more is an error of the write."""
    environment = {**os.environ, 'OMPI_ALLOW_RUN_AS_ROOT': '1', 'OMPI_ALLOW_RUN_AS_ROOT_CONFIRM': '1'}
    limited = ['bash', '-c', f'trap "" XFSZ; ulimit -f {largest_file}; exec "$@"', 'rank'] if largest_file else []
    command = ['mpirun', '-n', str(ranks), '--oversubscribe', *limited, PROGRAM, *args]
    return subprocess.Popen(command, cwd=FOLDER, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def finished(process, status=0):
    out, err = process.communicate(timeout=300)
    assert (process.returncode == 0) == (status == 0), (process.returncode, out, err)
    return out + err


def read(name):
    with open(os.path.join(FOLDER, name), 'rb') as f:
        return f.read()


def files():
    return sorted(os.listdir(FOLDER))


def test_the_file_is_that_of_one_rank():
    finished(run(1, 'one.bcc4', SIZE))
    said = finished(run(RANKS, 'many.bcc4', SIZE))
    assert len([line for line in said.splitlines() if line.strip()[:1].isdigit()]) == RANKS, said
    assert read('many.bcc4') == read('one.bcc4')
    assert files() == ['many.bcc4', 'one.bcc4'], files()


def test_a_rank_that_cannot_write_says_why():
    os.mkdir(os.path.join(FOLDER, 'bad.bcc4.block3.bcc4'))  # in the place of a rank's file
    said = finished(run(RANKS, 'bad.bcc4', SIZE), 1)
    assert 'rank 3: ' in said and 'bad.bcc4.block3.bcc4' in said, said
    assert not os.path.exists(os.path.join(FOLDER, 'bad.bcc4'))
    os.rmdir(os.path.join(FOLDER, 'bad.bcc4.block3.bcc4'))


def test_a_disk_that_is_full_loses_nothing_that_is_finished():
    # A limit on the size of files stands for a full disk: it hits the ranks whose blocks are largest.
    said = finished(run(RANKS, 'full.bcc4', SIZE, largest_file=len(read('one.bcc4')) // 12 // 1024), 1)
    assert 'rank ' in said, said
    assert not os.path.exists(os.path.join(FOLDER, 'full.bcc4'))
    finished(run(RANKS, 'full.bcc4', SIZE, '--resume'))
    assert read('full.bcc4') == read('one.bcc4')


def test_a_killed_rank_and_a_second_run():
    process = run(RANKS, 'killed.bcc4', SIZE)
    deadline = time.monotonic() + 120
    victims = []
    while not victims and time.monotonic() < deadline:
        time.sleep(.05)
        found = subprocess.run(['pgrep', '-P', str(process.pid)], capture_output=True, text=True).stdout.split()
        if len(found) == RANKS and any('killed.bcc4.block' in name for name in files()):
            victims = found
    os.kill(int(victims[2]), signal.SIGKILL)
    assert 'signal 9' in finished(process, 1)
    assert not os.path.exists(os.path.join(FOLDER, 'killed.bcc4'))
    finished(run(RANKS, 'killed.bcc4', SIZE, '--resume'))
    assert read('killed.bcc4') == read('one.bcc4')


def main():
    if not shutil.which('mpirun') or not os.path.exists(PROGRAM):
        print('skipped: no mpirun, or the examples were built without MPI')
        sys.exit(77)
    shutil.rmtree(FOLDER, ignore_errors=True)
    os.makedirs(FOLDER)
    for name, test in list(globals().items()):
        if name.startswith('test_'):
            test()
            print(name, 'ok')


main()
