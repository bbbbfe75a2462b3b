#!/usr/bin/env python3
"""Small faults in src/ at random, and whether a test sees them: `make mutants`, MUTANTS=100 SEED=number.

A fault is another operator, sign, bound, index, constant or order of arguments, a comparison turned round, or a
statement that is left out. The source with it is compiled in $(BUILD)/mutants, never in the checkout, and linked to a
library that the test programs there load in place of the sound one. Where the object code is the same in every
dimension the fault has no effect.

A map says which lines each test executes: the sources are built once more in $(BUILD)/mutants/cover, with a call at the
begin of each block of code (-fsanitize-coverage=trace-pc of gcc and clang). A test is one entry of a test program, one
scene of tests/scenes, a pair of random scenes of CI or a shell script that runs scenes. The map is kept; after a change
tests whose text differs run anew, and with other sources all do, unless --old-map says that lines are to be found again
by their text.

A fault is met by the tests that execute its line, cheap and near ones first, until one fails or --seconds of processor
time have passed. A line that no test executes has no test to run. A test that fails without a fault, too, counts for
nothing. Limits are processor time. --jobs tests and faults are looked at side by side, one for each core. What no test sees runs once more with the address and undefined-behaviour sanitizers
in all sources, as CI runs them, in one dimension: a fault that leaves an array counts as seen.

Printed are faults that no test has seen, and last a line "N mutants, N built, N with an effect, N killed, N survived".
The status is 0. The same seed and sources give the same faults. --unseen prints the lines that no test executes.
"""
import argparse
import array
import bisect
import collections
import contextlib
import difflib
import fcntl
import hashlib
import math
import multiprocessing
import os
import pickle
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
import zlib

DIMS = (1, 2, 3)
SHELL = 2  # distance of shell tests, whose scenes go through most modules
MEMORY = 8 << 30  # [bytes] that a test may have
WAIT = 20.0  # times its processor time, and a minute, may a test take by the clock: it may wait for ever

# ---- faults ----


def blank(text):
    """The same text without what stands in comments, strings and directives, every place kept."""
    out, k, state = list(text), 0, ''
    while k < len(text):
        two = text[k:k + 2]
        if state == '':
            line = text.rfind('\n', 0, k) + 1
            if two == '/*':
                state = '*/'
            elif text[k] in '"\'':
                state = text[k]
            elif text[k] == '#' and not text[line:k].strip():
                state = '\n'
            k += 1 if state in ('', '\n', '"', "'") else 2
            if state == '\n':
                out[k - 1] = ' '
            elif state == '*/':
                out[k - 2:k] = '  '
            continue
        if state == '\n' and text[k] == '\\' and text[k + 1:k + 2] == '\n':
            k += 2
        elif state in '"\'' and text[k] == '\\':
            out[k:k + 2] = '  '
            k += 2
        elif text.startswith(state, k):
            if state == '*/':
                out[k:k + 2] = '  '
            k += len(state)
            state = ''
        else:
            if text[k] != '\n':
                out[k] = ' '
            k += 1
    return ''.join(out)


NAME = r'[A-Za-z_]\w*(?:(?:->|\.)\w+)*(?:\[[\w +*-]*\])?'
SWAP = {'<': '<=', '<=': '<', '>': '>=', '>=': '>', '==': '!=', '!=': '==', '&&': '||', '||': '&&', '+': '-', '-': '+',
        '*': '/', '/': '*', '+=': '-=', '-=': '+='}

COMMUTE = re.compile(r'\b(pdi_vec_dot|hypot|fmin|fmax|pd_min|pd_max)\($')  # the order of their arguments changes no bit

TURNED = {'<': '>=', '<=': '>', '>': '<=', '>=': '<', '==': '!=', '!=': '=='}  # at a single value no number is met


def number(m):
    return {'0': '1', '1': '0', '0.0': '1.0', '1.0': '0.5', '0.5': '1.0', '2.0': '1.0'}.get(m.group(1), '')


# kind, weight, expression, what group 1 becomes
KINDS = [
    ('comparison', 5, re.compile(r' (<=|>=|<|>|==|!=) '), lambda m: TURNED[m.group(1)]),
    ('end', 3, re.compile(r'for \([^;{}]*; [^;{}]*?(<=|>=|<|>) '), lambda m: SWAP[m.group(1)]),
    ('connective', 2, re.compile(r' (&&|\|\|) '), lambda m: SWAP[m.group(1)]),
    ('operator', 6, re.compile(r'(?<=[\w\])]) ([-+*/]|[-+]=) (?=[\w(])'), lambda m: SWAP[m.group(1)]),
    ('sign', 3, re.compile(r'(?:[=(,?:] |[(\[]|return )(-)(?=[A-Za-z_(\d])'), lambda m: ''),
    ('not', 3, re.compile(r'(!)(?=[A-Za-z_(])'), lambda m: ''),
    ('bound', 3, re.compile(r'for \([\w ]*= (0|1);'), number),
    ('constant', 3, re.compile(r'(?<![\w.\[])(\d\.\d)(?![\w.])'), number),
    ('index', 4, re.compile(r'\[(0|1)\]'), number),
    ('shift', 4, re.compile(r'[\w\])]( [-+] 1)(?=[\]),;])'), lambda m: ''),
    ('limit', 2, re.compile(r'\b(pd_min|pd_max)(?=\()'), lambda m: 'pd_max' if m.group(1) == 'pd_min' else 'pd_min'),
    ('arguments', 2, re.compile(r'\w\((' + NAME + ', ' + NAME + r')\)'), lambda m: ', '.join(m.group(1).split(', ')[::-1])),
    ('call', 4, re.compile(r'^ +(?:if \([^;{}]*\) )?([A-Za-z_]\w*\([^;{}]*\));$', re.M), lambda m: ''),
    ('statement', 3, re.compile(r'^ +(?:if \([^;{}]*\) )?(' + NAME + r' [-+*/|&]?= [^;{}]*|' + NAME + r'(?:\+\+|--));$', re.M),
     lambda m: ''),
]


def faults(path):
    """kind -> [(from, to, text)] of a source."""
    text = open(path).read()
    code, found = blank(text), collections.defaultdict(list)
    depth, inside = 0, bytearray(len(code) + 1)
    for k, c in enumerate(code):  # bodies of functions alone
        depth += (c == '{') - (c == '}')
        inside[k] = depth > 0
    table = [m.span() for m in re.finditer(r'^static const [^;]*;', code, re.M | re.S)]
    for kind, _, expression, change in KINDS:
        for m in expression.finditer(code):
            a, b = m.span(1)
            new = change(m)
            statement = code[code.rfind('\n', 0, a) + 1:code.find('\n', a)]
            if not inside[a] or any(s <= a < e for s, e in table) or (new == '' and kind in ('bound', 'constant', 'index')):
                continue
            if kind in ('operator', 'comparison') and re.search(r'\b(sizeof|assert|PDI_ASSERT)\b', statement):
                continue
            if kind == 'arguments' and COMMUTE.search(code[:a]):
                continue
            if kind == 'call' and re.match(r'(PDI_ASSERT|assert|return|if|while|for|switch|sizeof)\b', m.group(1)):
                continue
            if text[a:b] != new:
                found[kind].append((a, b, new))
    return text, found


def draw(sources, rng, seen):
    """One fault that was not there before: path, text, (from, to, new), kind; a module as often as its lines."""
    while True:
        path = rng.choices(list(sources), [s[2] for s in sources.values()])[0]
        text, found, _ = sources[path]
        kinds = [k for k in KINDS if found[k[0]]]
        if not kinds:
            continue
        kind = rng.choices(kinds, [k[1] for k in kinds])[0][0]
        place = rng.choice(found[kind])
        if (path, place) not in seen:
            seen.add((path, place))
            return path, text, place, kind


# ---- the graph of includes ----

INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)


def included(path):
    return INCLUDE.findall(open(path, errors='replace').read())


class Graph:
    """How far a test is from a module: headers that it includes, what they and their sources include, and so on."""

    def __init__(self, root):
        self.root, self.uses, self.far = root, {}, {}
        for folder, _, names in os.walk(os.path.join(root, 'src')):
            for name in names:
                module = os.path.relpath(os.path.join(folder, name), os.path.join(root, 'src')).rsplit('.', 1)[0]
                if name.endswith(('.c', '.h')):
                    more = {n.rsplit('.', 1)[0] for n in included(os.path.join(folder, name))}
                    self.uses.setdefault(module, set()).update(more)

    def start(self, path, seen):
        modules = set()
        for name in included(path):
            near = next((p for p in (os.path.join(os.path.dirname(path), name), os.path.join(self.root, 'tests/lib', name),
                                   os.path.join(self.root, name))
                         if os.path.exists(p)), None)
            if near and near not in seen:
                modules |= self.start(near, seen | {near})
            elif name.rsplit('.', 1)[0] in self.uses:
                modules.add(name.rsplit('.', 1)[0])
        return modules

    def distance(self, test, module):
        if test not in self.far:
            far = {m: 0 for m in self.start(test, {test})}
            queue = collections.deque(far)
            while queue:
                at = queue.popleft()
                for other in self.uses.get(at, ()):
                    if other not in far:
                        far[other] = far[at] + 1
                        queue.append(other)
            self.far[test] = far
        return self.far[test].get(module)


# ---- building and running ----

# Marks the begin of blocks in the file $MUTANTS_SEEN.DIM, which all processes of a test share.
TRACE = r'''
#define _XOPEN_SOURCE 700
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>
extern const char __ehdr_start[] __attribute__((visibility("hidden")));
extern const char etext[] __attribute__((visibility("hidden")));
static unsigned char *seen;
void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void)
{
    if (seen) seen[(const char *)__builtin_return_address(0) - __ehdr_start] = 1;
}
__attribute__((constructor)) static void begin(void)
{
    char path[4096];
    size_t size = (size_t)(etext - __ehdr_start) + 64;
    if (!getenv("MUTANTS_SEEN")) return;
    snprintf(path, sizeof path, "%s.%d", getenv("MUTANTS_SEEN"), PD_DIM);
    int f = open(path, O_RDWR | O_CREAT, 0600);
    if (f < 0 || ftruncate(f, (off_t)size)) exit(99);
    void *at = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, f, 0);
    close(f);
    if (at != MAP_FAILED) seen = at;
}
'''

SANITIZED = ['-fsanitize=address,undefined', '-fsanitize-undefined-trap-on-error', '-fno-sanitize-recover=all']

Test = collections.namedtuple('Test', 'path dim entry')  # dim 0: a script; entry: of a program, or a scene, or ''


def name_of(test):
    return ' '.join([test.path] + (['%dD' % test.dim] if test.dim else []) + ([test.entry] if test.entry else []))


def marked(path, word, default):
    head = ''.join(open(path).readlines()[:5])
    m = re.search(word + r': *([1-3][1-3 ]*)', head)
    return [int(k) for k in m.group(1).split()] if m else default


def digest(paths):
    h = hashlib.sha1()
    for p in paths:
        h.update(open(p, 'rb').read())
    return h.hexdigest()


def living(session):
    """(process, seconds of processor time of it and of those that it has waited for) of a session."""
    found = []
    for name in os.listdir('/proc') if os.path.isdir('/proc') else ():
        if name.isdigit():
            try:
                f = open('/proc/%s/stat' % name).read().rsplit(')', 1)[1].split()
            except (OSError, IndexError):
                continue
            if int(f[3]) == session:
                found.append((int(name), sum(int(k) for k in f[11:15]) / os.sysconf('SC_CLK_TCK')))
    return found


def stop(session):
    """Ends all its processes: `timeout` gives those that it starts a group of their own."""
    for process, _ in living(session):
        try:
            os.kill(process, signal.SIGKILL)
        except OSError:
            pass


class Machine:
    def __init__(self, a):
        self.a, self.dir = a, os.path.join(a.build, 'mutants')
        self.cc = os.environ.get('CC', 'cc').split()
        self.dev = [f for f in os.environ.get('DEV', '-std=c99 -O2 -fPIC -DPDI_SPLIT').split() if not f.startswith('-W')]
        self.dev_test = os.environ.get('DEV_TEST', '-std=c99 -O1').split()
        self.traced = [f for f in self.dev if not re.match(r'-(O|g)', f)] + [
            '-Og', '-g1', '-fsanitize-coverage=trace-pc'] + ([] if 'clang' in self.cc[0] else ['-fno-reorder-blocks'])
        self.sanitizing = [f for f in self.dev if not re.match(r'-(O|g)', f)] + ['-O1'] + SANITIZED
        self.plain, self.built = {}, {}  # test -> it passes without a fault; test program -> its path, or None
        found = [subprocess.run(self.cc + ['-print-file-name=' + name], stdout=subprocess.PIPE).stdout.decode().strip()
                 for name in ('libasan.so', 'libclang_rt.asan-x86_64.so')]
        self.asan = next((os.path.realpath(f) for f in found if os.path.isabs(f)), None)
        for name in ('cover', 'plain', 'watched', 'programs'):
            os.makedirs(os.path.join(self.dir, name), exist_ok=True)
        self.take_job(0)

    def take_job(self, k):
        """What this process writes is in a folder of its own."""
        self.job = 'job%d' % k
        for name in ('fault', 'source', 'tmp'):
            os.makedirs(self.own(name), exist_ok=True)

    def own(self, name):
        return os.path.join(self.dir, self.job, name)

    @contextlib.contextmanager
    def alone(self):
        """No other process is in the same place."""
        with open(os.path.join(self.dir, 'lock'), 'w') as f:
            fcntl.flock(f, fcntl.LOCK_EX)
            yield

    @contextlib.contextmanager
    def jobs(self):
        """Processes side by side, each with a folder of its own."""
        fork, numbers = multiprocessing.get_context('fork'), multiprocessing.get_context('fork').SimpleQueue()
        for k in range(self.a.jobs):
            numbers.put(k)
        pool = fork.Pool(self.a.jobs, lambda: self.take_job(numbers.get()))
        try:
            yield pool
            pool.close()
        except BaseException:
            pool.terminate()
            raise
        finally:
            pool.join()

    def call(self, command, limit=None, room=MEMORY, **more):
        """Status, seconds of processor time and output; status -1: it took longer than `limit` seconds of it, or WAIT
        times that by the clock."""
        env = dict(os.environ, OMP_NUM_THREADS='1', OMP_WAIT_POLICY='passive', **more)

        def bound():
            if room:
                resource.setrlimit(resource.RLIMIT_AS, (room, room))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if limit:
                resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 2))

        begin, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        path = self.own('output')
        with open(path, 'wb') as f:
            p = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=f, stderr=subprocess.STDOUT, env=env,
                                 start_new_session=True, preexec_fn=bound)
        ended = False
        while not ended:
            try:
                p.wait(timeout=1.0)
                break
            except subprocess.TimeoutExpired:
                ended = bool(limit) and (sum(s for _, s in living(p.pid)) > limit or
                                         time.monotonic() - clock > 60.0 + WAIT * limit)
        stop(p.pid)  # what it has left, too
        p.wait()
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
        took = end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime
        status = -1 if ended or p.returncode == -signal.SIGXCPU else p.returncode
        took = max(took, limit) if status == -1 else took  # the processes of one that is ended are not counted
        return status, took, open(path, 'rb').read(1 << 20).decode(errors='replace')

    def link(self, to, d, objects):
        path = os.path.join(self.dir, to, 'libpdcorr%dd.so' % d)
        flags = [f for f in self.dev if f.startswith(('-fopenmp', '-fsanitize'))]
        status, _, out = self.call(self.cc + ['-shared', '-Wl,-Bsymbolic-functions,-soname,libpdcorr%dd.so' % d] + flags +
                                   ([] if to == 'cover' else ['-Wl,-S']) + objects + ['-o', path + '.new', '-lm'])
        if status:
            sys.exit('mutants: ' + out)
        os.replace(path + '.new', path)
        return path

    def objects(self, d):
        return [os.path.join(self.a.build, 'obj%dd' % d, s[:-2] + '.o') for s in self.a.sources]

    def compile(self, source, d, to, flags=None):
        # asserts hold the name of the source; without notes for debuggers the code is the same
        name = '-fmacro-prefix-map=%s=src' % self.own('source')
        status, _, out = self.call(self.cc + (flags or [f for f in self.dev if not f.startswith('-g')]) + [name, '-DPD_DIM=%d' % d, '-Isrc', '-c', source, '-o', to])
        return status == 0, out

    def sanitized(self, d):
        """Objects of all sources with sanitizers, kept, and a library of them."""
        objects, renewed = [], False
        for s in self.a.sources:
            o = os.path.join(self.dir, 'watched', 'obj%dd' % d, s[:-2] + '.o')
            os.makedirs(os.path.dirname(o), exist_ok=True)
            original = os.path.join(self.a.build, 'obj%dd' % d, s[:-2] + '.o')  # made again with any header
            if not os.path.exists(o) or os.path.getmtime(o) < os.path.getmtime(original):
                if not self.compile(os.path.join('src', s), d, o, self.sanitizing)[0]:
                    return []
                renewed = True
            objects.append(o)
        if renewed or not os.path.exists(os.path.join(self.dir, 'watched', 'libpdcorr%dd.so' % d)):
            self.link('watched', d, objects)
        return objects

    def same(self, one, two):
        """The same code and data, whatever their notes for debuggers say."""
        stripped = []
        for k, path in enumerate((one, two)):
            to = self.own('same%d.o' % k)
            if subprocess.call(['objcopy', '-g', '--remove-section=.comment', path, to]):
                return False
            stripped.append(open(to, 'rb').read())
        return stripped[0] == stripped[1]

    def program(self, path, d):
        """The program of a test, built once; None: it does not build."""
        if (path, d) in self.built:
            return self.built[path, d]
        to = os.path.join(self.dir, path[:-2].replace('/', '_') + '_%dd' % d)
        sources = [path]
        if path == METAMORPHIC:
            sources = sorted(os.path.join(os.path.dirname(path), n) for n in os.listdir(os.path.dirname(path)) if n.endswith('.c'))
        note, now = to + '.of', digest(needed(sources) + self.headers)
        if not os.path.exists(to) or not os.path.exists(note) or open(note).read() != now:
            more = ['-I.', '-DPDCORR_LINKED'] if path.startswith('drivers') else ['-DPDI_SPLIT', '-Isrc', '-I.']
            status, _, out = self.call(
                self.cc + self.dev_test + ['-DPD_DIM=%d' % d, '-Itests/lib', '-Itests/hard'] + more + sources +
                ['-o', to, self.shared[d], '-Wl,--enable-new-dtags', '-lm'])
            if status:
                print('mutants: %s does not build: %s' % (to, out.strip()[:300]))
                to = None
            else:
                open(note, 'w').write(now)
        self.built[path, d] = to
        return to

    def run(self, test, limit, library, **more):
        if test.dim:
            command = [self.program(test.path, test.dim)] + test.entry.split()
        else:
            command = ['sh', test.path]
            if test.entry:
                more['SCENES'] = test.entry
        where = ':'.join(os.path.abspath(os.path.join(self.dir, l)) for l in (library, 'plain'))
        tmp = os.path.abspath(self.own('tmp'))
        result = self.call(command, limit, PROGRAMS=os.path.join(self.dir, 'programs'), BUILD=os.path.join(self.dir, 'home'),
                           LD_LIBRARY_PATH=where, TMPDIR=tmp, **more)
        for name in os.listdir(tmp):
            shutil.rmtree(os.path.join(tmp, name), ignore_errors=True)
        return result

    def watched(self, test, limit, library):
        """The same under the runtime of the address sanitizer, which needs all addresses."""
        return self.run(test, limit, library, room=None, LD_PRELOAD=self.asan,
                        ASAN_OPTIONS='detect_leaks=0:detect_odr_violation=0:verify_asan_link_order=0')

    def sound(self, test, limit):
        """It passes without a fault."""
        if test not in self.plain:
            status, _, _ = self.run(test, limit, 'plain')
            self.plain[test] = status == 0
            if status:
                print('mutants: %s fails without a fault and is not used' % name_of(test))
        return self.plain[test]

    def prepare(self):
        """Libraries without a fault, and programs of scenes."""
        self.shared = {d: self.link('plain', d, self.objects(d)) for d in DIMS}
        self.headers = sorted(os.path.join(f, n) for f, _, names in os.walk('src') for n in names if n.endswith('.h'))
        self.headers += [n for n in ('pdcorr.h', 'pdcorr_app.h') if os.path.exists(n)]
        for d in DIMS if os.path.exists('drivers/scene.c') else ():
            built = self.program('drivers/scene.c', d)
            to = os.path.join(self.dir, 'programs', 'pd%dd' % d)
            if built and not os.path.exists(to):
                if os.path.islink(to):
                    os.remove(to)  # of a folder that has moved
                os.symlink(os.path.abspath(built), to)
        # shell tests find programs in the build folder, too: those of here, and the others
        home = os.path.join(self.dir, 'home')
        shutil.rmtree(home, ignore_errors=True)
        os.makedirs(home)
        for name in os.listdir(self.a.build):
            own = os.path.join(self.dir, 'programs', name)
            os.symlink(os.path.abspath(own if os.path.exists(own) else os.path.join(self.a.build, name)),
                       os.path.join(home, name))
        for name in os.listdir(os.path.join(self.dir, 'programs')):
            if not os.path.lexists(os.path.join(home, name)):
                os.symlink(os.path.abspath(os.path.join(self.dir, 'programs', name)), os.path.join(home, name))


# ---- tests ----

METAMORPHIC = 'tests/metamorphic/main.c'
PAIRS = {1: 50, 2: 100, 3: 50}  # those of CI, from seed 1 on


def needed(sources):
    """The sources and what they include from tests/ and cases/."""
    found = list(sources)
    for path in found:
        for name in included(path):
            for near in (os.path.join(os.path.dirname(path), name), os.path.join('tests/lib', name), os.path.join('tests/hard', name), name):
                if os.path.exists(near) and near not in found:
                    found.append(near)
    return found


def all_tests(m):
    """Test -> digest of its text."""
    tests = {}
    for folder in ['tests/' + room for room in sorted(os.listdir('src'))] + ['tests/hard', 'tests/scripts']:
        for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else ():
            path = os.path.join(folder, name)
            if re.match(r'test_\w+\.c$', name):
                text = digest(needed([path]))
                for d in marked(path, 'dims', [2]):
                    if m.a.dims and str(d) not in m.a.dims or d in marked(path, 'slow', []):
                        continue
                    if not re.search(m.a.tests.split(' ')[0], path) or not m.program(path, d):
                        continue
                    status, _, out = m.call([m.program(path, d), '--list'], LD_LIBRARY_PATH=os.path.abspath(os.path.join(m.dir, 'plain')))
                    entries = [e for e in out.splitlines() if not e.endswith(' (slow)')] if status == 0 else []
                    tests.update({Test(path, d, e): text for e in entries or ['']})
            elif name == 'scene_figures.sh':
                for scene in sorted(os.listdir('tests/scenes')):
                    scene = os.path.join('tests/scenes', scene)
                    if scene.endswith('.scene'):
                        tests[Test(path, 0, scene)] = digest([path, scene])
            elif name.endswith('.sh') and folder == 'tests/scripts' and name != 'mutants.sh':
                text = open(path).read()
                if '$programs/' in text and 'slow: yes' not in text and not re.search(r'\$CC|chromedriver|valgrind', text):
                    tests[Test(path, 0, '')] = digest([path])
    for d in DIMS if os.path.exists(METAMORPHIC) else ():
        if (not m.a.dims or str(d) in m.a.dims) and m.program(METAMORPHIC, d):
            here = os.path.dirname(METAMORPHIC)
            text = digest(needed(sorted(os.path.join(here, n) for n in os.listdir(here))))
            tests[Test(METAMORPHIC, d, '--quick')] = text
            for seed in range(1, PAIRS[d] + 1):
                tests[Test(METAMORPHIC, d, '--seed %d --pairs 1 --closed' % seed)] = text
    return {t: text for t, text in tests.items() if re.search(m.a.tests, name_of(t))}


# ---- which lines a test executes ----


class Map:
    """`tests`: name -> {'text', 'seconds', 'passes', 'lines'}, lines those of self.lines by number, compressed."""

    def __init__(self, m):
        self.m, self.path = m, os.path.join(m.dir, 'map')
        self.tests, self.sources, self.ids, self.lines, self.code = {}, {}, {}, [], set()
        if os.path.exists(self.path):
            self.tests, self.sources, self.lines, self.code = pickle.load(open(self.path, 'rb'))
            self.ids = {l: k for k, l in enumerate(self.lines)}

    def save(self):
        pickle.dump((self.tests, self.sources, self.lines, self.code), open(self.path + '.new', 'wb'))
        os.replace(self.path + '.new', self.path)

    def number(self, line):
        if line not in self.ids:
            self.ids[line] = len(self.lines)
            self.lines.append(line)
        return self.ids[line]

    def build(self):
        """Libraries that mark what they execute. blocks[d]: addresses of blocks -> numbers of their lines."""
        m = self.m
        trace = os.path.join(m.dir, 'cover', 'trace.c')
        open(trace, 'w').write(TRACE)
        self.blocks = {}
        for d in DIMS:
            objects = []
            for s in m.a.sources:
                o = os.path.join(m.dir, 'cover', 'obj%dd' % d, s[:-2] + '.o')
                os.makedirs(os.path.dirname(o), exist_ok=True)
                original = os.path.join(m.a.build, 'obj%dd' % d, s[:-2] + '.o')  # made again with any header
                if not os.path.exists(o) or os.path.getmtime(o) < os.path.getmtime(original):
                    fine, out = m.compile(os.path.join('src', s), d, o, m.traced)
                    if not fine:
                        sys.exit('mutants: ' + out)
                objects.append(o)
            o = os.path.join(m.dir, 'cover', 'trace%d.o' % d)
            fine, out = m.compile(trace, d, o, ['-O2', '-fPIC'])
            if not fine:
                sys.exit('mutants: ' + out)
            self.blocks[d] = self.table(m.link('cover', d, objects + [o]))

    def table(self, library):
        # rows of a block: from its call, in a function's first block from the function's begin
        bounds, marks, begin, call = [], {}, None, None
        out = subprocess.run(['objdump', '-d', '--no-show-raw-insn', library], stdout=subprocess.PIPE, check=True).stdout
        for line in out.decode(errors='replace').splitlines():
            if line.endswith('>:'):
                begin = int(line.split()[0], 16)
                bounds.append(begin)
            elif line.startswith(' '):
                at = int(line[:line.index(':')], 16)
                if call is not None:
                    marks[call] = at
                call = None
                if '<__sanitizer_cov_trace_pc' in line and 'call' in line:
                    call = at if begin is None else begin
                    bounds.append(call)
                    begin = None
        lines, unit = collections.defaultdict(set), ''
        bounds = sorted(set(bounds))
        out = subprocess.run(['readelf', '--debug-dump=decodedline', '-W', library], stdout=subprocess.PIPE, check=True,
                             stderr=subprocess.DEVNULL).stdout
        for line in out.decode(errors='replace').splitlines():
            f = line.split()
            if line.startswith('CU: '):
                unit = os.path.relpath(line[4:].rstrip(':'), 'src')
            elif len(f) >= 3 and os.path.basename(f[0]) == os.path.basename(unit) and f[1].isdigit() and f[2].startswith('0x'):
                at = bisect.bisect_right(bounds, int(f[2], 16)) - 1
                n = self.number((unit, int(f[1])))
                self.code.add(n)
                if at >= 0:
                    lines[bounds[at]].add(n)
        return {marks[at]: n for at, n in lines.items() if at in marks}

    def trace(self, test, text):
        m, seen = self.m, os.path.abspath(self.m.own('seen'))
        status, took, out = m.run(test, m.a.longest, 'cover', MUTANTS_SEEN=seen)
        found = {}
        for d in DIMS:
            path = '%s.%d' % (seen, d)
            if os.path.exists(path):
                numbers = set()
                data = open(path, 'rb').read()
                for run in re.finditer(b'\x01', data):
                    numbers.update(self.blocks[d].get(run.start(), ()))
                found[d] = zlib.compress(array.array('I', sorted(numbers)).tobytes(), 1)
                os.remove(path)
        if status:
            print('mutants: %s' % name_of(test), 'takes more than %g s: lines that it executes later are not known' %
                  m.a.longest if status == -1 else 'fails without a fault and is not used')
            sys.stdout.flush()
        return name_of(test), {'text': text, 'seconds': took, 'passes': status in (0, -1), 'lines': found}

    def renew(self, tests):
        """Runs the tests that the map does not have."""
        now = {s: open(os.path.join('src', s)).read() for s in self.m.a.sources}
        if self.sources != now and self.tests and self.m.a.old_map:
            self.move(now)
        elif self.sources != now:
            self.tests, self.ids, self.lines, self.code = {}, {}, [], set()
        self.sources = now
        wanted = {name_of(t) for t in tests}
        if not self.m.a.dims and not self.m.a.tests:
            self.tests = {n: t for n, t in self.tests.items() if n in wanted}
        missing = [t for t, text in tests.items() if self.tests.get(name_of(t), {}).get('text') != text and
                   not (self.m.a.old_map and name_of(t) in self.tests)]
        if not missing or self.m.a.as_is:
            return
        begin, saved = time.monotonic(), time.monotonic()
        self.build()
        print('mutants: the map of which lines are executed: %d of %d tests to run' % (len(missing), len(tests)))
        sys.stdout.flush()
        share(trace=self.trace)
        with self.m.jobs() as pool:
            order = sorted(missing, key=lambda t: (t.dim == 3, not t.dim))
            for name, found in pool.imap_unordered(shared, [('trace', test, tests[test]) for test in order]):
                self.tests[name] = found
                if time.monotonic() - saved > 60.0:
                    saved = time.monotonic()
                    self.save()
        self.save()
        print('mutants: they took %.0f s of processor time and %.0f s' % (
            sum(self.tests[name_of(t)]['seconds'] for t in missing), time.monotonic() - begin))

    def move(self, now):
        """Lines of changed sources are those of the same text; a new line is executed where the one before it is. A new
        source has those of the old one in its folder with which it shares most lines."""
        follow = {}
        for s, text in now.items():
            of, lines = s, text.split('\n')
            if s not in self.sources:
                near = [o for o in self.sources if os.path.dirname(o) == os.path.dirname(s)]
                of = max(near, key=lambda o: len(set(lines) & set(self.sources[o].split('\n'))), default=None)
            if of is None or self.sources[of] == text:
                continue
            match = difflib.SequenceMatcher(None, self.sources[of].split('\n'), lines, False)
            for what, a, b, c, e in match.get_opcodes():
                for k in range(c, e):
                    from_ = a + min(k - c, max(b - a - 1, 0)) if what != 'insert' else a - 1
                    follow.setdefault((of, from_ + 1), []).append((s, k + 1))
            for n, line in enumerate(self.lines):
                if line[0] == s:
                    follow.setdefault(line, [])
        if not follow:
            return
        same = {s for s, text in now.items() if self.sources.get(s) == text}
        to = [[self.number(l) for l in follow.get(line, []) + [line] * (line[0] in same or line not in follow)]
              for line in list(self.lines)]
        for t in self.tests.values():
            for d, packed in t['lines'].items():
                numbers = array.array('I')
                numbers.frombytes(zlib.decompress(packed))
                t['lines'][d] = zlib.compress(array.array('I', sorted({x for n in numbers for x in to[n]})).tobytes(), 1)
        self.code = {x for n in self.code for x in to[n]}

    def spread(self, tests):
        """self.by[d][line number]: the tests that execute the line; self.full: lines that have code."""
        self.by = {d: collections.defaultdict(list) for d in DIMS}
        for test in tests:
            t = self.tests.get(name_of(test))
            for d, packed in t['lines'].items() if t and t['passes'] else ():
                numbers = array.array('I')
                numbers.frombytes(zlib.decompress(packed))
                for n in numbers:
                    self.by[d][n].append(test)
        self.full = collections.defaultdict(list)
        for n in self.code:
            self.full[self.lines[n][0]].append(self.lines[n][1])
        for lines in self.full.values():
            lines.sort()

    def meeting(self, source, line):
        """{test: dimensions} of the tests that execute a line, or the one before it that has code; of what stands
        before all code, those that execute any of it."""
        k = bisect.bisect_right(self.full[source], line) - 1
        found = {}
        for l in self.full[source][k:k + 1] if k >= 0 else self.full[source]:
            for d in DIMS:
                for test in self.by[d].get(self.ids[source, l], ()):
                    if d not in found.setdefault(test, []):
                        found[test].append(d)
        return found

    def unseen(self):
        """(source, line) that have code and that no test executes."""
        seen = set().union(*(self.by[d] for d in DIMS))
        return sorted(self.lines[n] for n in self.code - seen)


# ---- a fault ----


class Fault:
    """A source with a fault: its objects, compiled where they are asked for."""

    def __init__(self, m, path, text, changed):
        self.m, self.path, self.state = m, path, {}
        self.source = os.path.join(m.own('source'), path)
        os.makedirs(os.path.dirname(self.source), exist_ok=True)
        open(self.source, 'w').write(changed)
        for d in DIMS:
            library = os.path.join(m.own('fault'), 'libpdcorr%dd.so' % d)
            if os.path.exists(library):
                os.remove(library)

    def effect(self, d):
        """'' where it does not build, 'none', or 'some'; in the last case the library with it is there."""
        if d in self.state:
            return self.state[d]
        m, to = self.m, self.m.own('mutant%dd.o' % d)
        original = os.path.join(m.a.build, 'obj%dd' % d, self.path[:-2] + '.o')
        if not m.compile(self.source, d, to)[0]:
            self.state[d] = ''
        elif m.same(original, to):
            self.state[d] = 'none'
        else:
            self.state[d] = 'some'
            m.link(m.job + '/fault', d, [to if o == original else o for o in m.objects(d)])
        return self.state[d]


    def watch(self, d):
        """Libraries where the sanitizers see what all sources do, with the fault and without: arrays of one source are
        lent to others."""
        m, to = self.m, self.m.own('watched%dd.o' % d)
        with m.alone():
            objects = m.sanitized(d)
        own = os.path.join(m.dir, 'watched', 'obj%dd' % d, self.path[:-2] + '.o')
        if not objects or not m.compile(self.source, d, to, m.sanitizing)[0]:
            return False
        m.link(m.job + '/fault', d, [to if o == own else o for o in objects])
        return True


def watch(m, fault, line, known):
    """As judge, of a fault that no test sees by itself: the sanitizers say whether it leaves an array."""
    total, used, ready = 0.0, 0, {}
    met = {t: d for t, d in known.meeting(fault.path, line).items() if t.dim and t.path != METAMORPHIC}
    dims = [d for d in (2, 3, 1) if fault.state.get(d) == 'some' and any(t.dim == d for t in met)][:1]  # it costs a build
    for test in sorted((t for t in met if t.dim in dims), key=lambda t: known.tests[name_of(t)]['seconds']):
        d = test.dim
        if total > 0.25 * m.a.seconds or not m.asan:
            break
        if fault.state.get(d) != 'some' or m.plain.get(test) is False:
            continue
        if d not in ready:
            ready[d] = fault.watch(d)
        limit = 10.0 + 20.0 * known.tests[name_of(test)]['seconds']
        status, took, out = m.watched(test, limit, m.job + '/fault') if ready[d] else (0, 0.0, '')
        total += took
        used += 1
        if status and m.watched(test, limit, 'watched')[0] == 0:
            said = re.findall(r'AddressSanitizer: [^\n]*', out)
            return test, (said or ['status %d' % status])[0], total, used
    return None, '', total, used


def judge(m, graph, fault, line, known):
    """The test that sees the fault, or None; what it said, seconds spent, tests run, tests that execute the line."""
    met = known.meeting(fault.path, line)

    def place(test):  # cheap and near ones first
        far = graph.distance(test.path, fault.path[:-2]) if test.dim and test.path != METAMORPHIC else SHELL
        return math.log2(0.02 + known.tests[name_of(test)]['seconds']) + min(SHELL if far is None else far, SHELL), name_of(test)

    total, used = 0.0, 0
    for test in sorted(met, key=place):
        if total > m.a.seconds:
            break
        effects = [fault.effect(d) for d in met[test]]
        if '' in effects:
            break
        if 'some' not in effects or m.plain.get(test) is False:
            continue
        limit = 5.0 + 5.0 * known.tests[name_of(test)]['seconds']
        status, took, out = m.run(test, limit, m.job + '/fault')
        total += took
        used += 1
        if status and m.sound(test, limit):
            said = [l for l in out.splitlines() if not l.startswith('note') and re.search(r': \w+: |^failed: |assert|ERROR', l)]
            return test, (said or ['no end' if status == -1 else 'status %d' % status])[0].strip(), total, used, len(met)
    return None, '', total, used, len(met)


def weigh(m, graph, known, path, text, changed, line, head, diff):
    """What a fault counts as, and what is printed of it."""
    fault = Fault(m, path, text, changed)
    test, said, took, used, meet = judge(m, graph, fault, line, known)
    if not test:
        for d in DIMS:
            if '' not in fault.state.values() and 'some' not in fault.state.values():
                fault.effect(d)
    if '' in fault.state.values():
        return (), ''
    if 'some' not in fault.state.values():
        return ('built',), '%s: no effect' % head
    seen_by = ''
    if not test and meet:
        test, said, more, used = watch(m, fault, line, known)
        took += more
        seen_by = ' under the address sanitizer'
    if test:
        return ('built', 'effect', 'killed') + (('watched',) if seen_by else ()), '%s: killed after %.0f s%s by test %d of %d, %s: %s' % (
            head, took, seen_by, used, meet, name_of(test), said[:160])
    return ('built', 'effect', 'survived'), ('SURVIVED %d of %d tests in %.0f s: %s' % (used, meet, took, diff) if meet else
                                             'SURVIVED, since no test executes the line: %s' % diff)


# ---- side by side ----

SHARED = {}  # functions of this process, which those that it forks call by name


def share(**functions):
    SHARED.update(functions)


def shared(call):
    return SHARED[call[0]](*call[1:])


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument('--seed', type=int, help='of the faults; without: by the clock')
    p.add_argument('--count', type=int, default=100, help='faults with an effect')
    p.add_argument('--seconds', type=float, default=300, help='of processor time in tests for a fault, after which it has survived')
    p.add_argument('--longest', type=float, default=60, help='a test is followed for so many of them')
    p.add_argument('--only', default='', help='folders or files below src, with commas between them')
    p.add_argument('--dims', default='', help='of the test programs that are used, such as 1,2')
    p.add_argument('--tests', default='', help='use those alone whose name (FILE DIM ENTRY) has this regular expression, up to its first blank in FILE')
    p.add_argument('--at', help='FILE:LINE: the faults of a line below src, one after the other')
    p.add_argument('--jobs', type=int, default=len(os.sched_getaffinity(0)), help='processes side by side')
    p.add_argument('--build', default='build')
    p.add_argument('--list', action='store_true', help='print the faults and stop')
    p.add_argument('--unseen', action='store_true', help='print the lines that no test executes and stop')
    p.add_argument('--as-is', action='store_true', help='run no test for the map: those that it does not have are not used')
    p.add_argument('--old-map', action='store_true', help='after a change of sources, find the lines of the old map by their text, also in files that were divided; run tests for the map that it does not have')
    a = p.parse_args()
    if a.seed is None:
        a.seed = int(time.time()) % 1000000
    a.sources = sorted(os.path.relpath(os.path.join(f, n), 'src') for f, _, names in os.walk('src') for n in names
                       if n.endswith('.c'))
    wanted = [s for s in a.sources if not a.only or any(s == o or s.startswith(o.rstrip('/') + '/') for o in a.only.split(','))]
    if a.at:
        wanted = [a.at.split(':')[0]]
    if not wanted or any(not os.path.exists(os.path.join('src', s)) for s in wanted):
        sys.exit('mutants: no source of src is %s' % (a.at or a.only))
    sources = {}
    for s in wanted:
        text, found = faults(os.path.join('src', s))
        sources[s] = (text, found, text.count('\n'))
    rng, seen, queue = random.Random(a.seed), set(), None
    if a.at:
        line = int(a.at.split(':')[1])
        text, found, _ = sources[wanted[0]]
        queue = [(wanted[0], text, place, kind) for kind in found for place in found[kind]
                 if text.count('\n', 0, place[0]) + 1 == line]
        a.count = len(queue)
    print('mutants: seed %d, %d faults to draw from' % (a.seed, sum(len(f) for s in sources.values() for f in s[1].values())))
    begin = spent()
    if not a.list:
        m, graph = Machine(a), Graph('.')
        m.prepare()
        tests, known = all_tests(m), Map(m)
        known.renew(tests)
        known.spread(tests)
    if a.unseen:
        for s, line in known.unseen():
            if s in sources:
                print('src/%s:%d: %s' % (s, line, sources[s][0].split('\n')[line - 1].strip()))
        return
    room = sum(len(f) for s in sources.values() for f in s[1].values())
    drawn, wanted = 0, a.count

    def next_fault():
        """(path, text, changed text, line, head, what is printed), or None."""
        nonlocal drawn
        if drawn >= (min(wanted, room) if a.list or a.at else room):
            return None
        path, text, (x, y, new), kind = queue[drawn] if queue is not None else draw(sources, rng, seen)
        drawn += 1
        line = text.count('\n', 0, x) + 1
        changed = text[:x] + new + text[y:]
        old, now = (t.split('\n')[line - 1].strip() for t in (text, changed))
        head = 'src/%s:%d: %s' % (path, line, kind)
        diff = '%s\n    - %s\n    + %s' % (head, old, now)
        if '\n' in text[x:y]:
            diff += ' ... (the statement is left out)'
        return path, text, changed, line, head, diff

    if a.list:
        for fault in iter(next_fault, None):
            print(fault[-1])
        print('%d mutants, 0 built, 0 with an effect, 0 killed, 0 survived' % drawn)
        return
    sum_of = collections.Counter()
    share(weigh=lambda *fault: weigh(m, graph, known, *fault))
    with m.jobs() as pool:
        pending = collections.deque()
        while sum_of['effect'] < wanted:
            while len(pending) < a.jobs:
                fault = next_fault()
                if not fault:
                    break
                pending.append(pool.apply_async(shared, (('weigh',) + fault,)))
            if not pending:
                break
            counts, text = pending.popleft().get()
            sum_of.update(counts)
            if text:
                print(text)
                sys.stdout.flush()
        drawn -= len(pending)
    print('mutants: %.0f s of processor time; %d of the killed by sanitizers' % (spent() - begin, sum_of['watched']))
    print('%d mutants, %d built, %d with an effect, %d killed, %d survived' % (
        drawn, sum_of['built'], sum_of['effect'], sum_of['killed'], sum_of['survived']))


def spent():
    use = [resource.getrusage(k) for k in (resource.RUSAGE_CHILDREN, resource.RUSAGE_SELF)]
    return sum(u.ru_utime + u.ru_stime for u in use)


if __name__ == '__main__':
    main()
