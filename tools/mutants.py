#!/usr/bin/env python3
"""Small faults in src/ at random, and whether a test sees them: `make mutants`, MUTANTS=100 SEED=number.

A fault is another operator, sign, bound, index, constant or order of arguments, a comparison turned round, or a
statement that is left out. The source with it is compiled in $(BUILD)/mutants, never in the checkout, and linked to libraries that the test
programs there share. Where the object code is the same in every dimension the fault has no effect. The tests run from
the nearest to the farthest in the graph of includes, then the shell tests that run scenes, until one fails or --seconds
of processor time have passed. A test that fails without a fault, too, counts for nothing.

Printed are faults that no test has seen, and last a line "N mutants, N built, N with an effect, N killed, N survived".
The status is 0. The same seed and sources give the same faults.
"""
import argparse
import collections
import json
import math
import os
import random
import re
import resource
import signal
import subprocess
import sys
import time

DIMS = (1, 2, 3)
SHELL = 2  # distance of shell tests, whose scenes go through most modules

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
    ('limit', 2, re.compile(r'\b(pdi_min|pdi_max)(?=\()'), lambda m: 'pdi_max' if m.group(1) == 'pdi_min' else 'pdi_min'),
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
            near = next((p for p in (os.path.join(os.path.dirname(path), name), os.path.join(self.root, 'tests', name))
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

def marked(path, word, default):
    head = ''.join(open(path).readlines()[:5])
    m = re.search(word + r': *([1-3][1-3 ]*)', head)
    return [int(k) for k in m.group(1).split()] if m else default


def spent():
    """Seconds of processor time of all that has been run."""
    use = resource.getrusage(resource.RUSAGE_CHILDREN)
    return use.ru_utime + use.ru_stime


class Machine:
    def __init__(self, a):
        self.a, self.dir = a, os.path.join(a.build, 'mutants')
        self.cc = os.environ.get('CC', 'cc').split()
        self.dev = [f for f in os.environ.get('DEV', '-std=c99 -O2 -fPIC -DPDI_SPLIT').split() if not f.startswith('-W')]
        self.dev_test = os.environ.get('DEV_TEST', '-std=c99 -O1').split()
        self.plain = {}  # test -> it passes without a fault
        os.makedirs(self.dir, exist_ok=True)
        times = os.path.join(self.dir, 'times.json')
        self.times = json.load(open(times)) if os.path.exists(times) else {}  # name of a test -> seconds, for the order

    def call(self, command, limit=None, **more):
        """Status, seconds of processor time and output; status -1: it took longer than `limit` seconds, or ten times
        that by the clock."""
        env = dict(os.environ, OMP_NUM_THREADS='1', OMP_WAIT_POLICY='passive', **more)
        begin = spent()
        p = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=env,
                             start_new_session=True, preexec_fn=(lambda: resource.setrlimit(
                                 resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 2))) if limit else None)
        try:
            out = p.communicate(timeout=10.0 * limit if limit else None)[0]
        except subprocess.TimeoutExpired:
            os.killpg(p.pid, 9)
            p.communicate()
            return -1, spent() - begin, ''
        return -1 if p.returncode == -signal.SIGXCPU else p.returncode, spent() - begin, out.decode(errors='replace')

    def objects(self, d):
        return [os.path.join(self.a.build, 'obj%dd' % d, s[:-2] + '.o') for s in self.a.sources]

    def library(self, d):
        return os.path.join(self.dir, 'libpdcorr%dd.so' % d)

    def link(self, d, swap=None):
        objects = self.objects(d)
        if swap:
            objects = [swap[1] if o == swap[0] else o for o in objects]
        new = self.library(d) + '.new'
        flags = [f for f in self.dev if f.startswith(('-fopenmp', '-fsanitize'))]
        name = '-Wl,-soname,' + os.path.basename(self.library(d))  # found from any folder
        status, _, out = self.call(self.cc + ['-shared', name] + flags + objects + ['-o', new, '-lm'])
        if status:
            sys.exit('mutants: ' + out)
        os.replace(new, self.library(d))

    def compile(self, source, d, to):
        status, _, out = self.call(self.cc + self.dev + ['-DPD_DIM=%d' % d, '-Isrc', '-c', source, '-o', to])
        return status == 0, out

    def same(self, one, two):
        """The same code and data, whatever their notes for debuggers say."""
        stripped = []
        for k, path in enumerate((one, two)):
            to = os.path.join(self.dir, 'same%d.o' % k)
            if subprocess.call(['objcopy', '-g', '--remove-section=.comment', path, to]):
                return False
            stripped.append(open(to, 'rb').read())
        return stripped[0] == stripped[1]

    def program(self, test):
        """The program of a test, built once."""
        path, d = test
        to = os.path.join(self.dir, os.path.basename(path)[:-2] + '_%dd' % d)
        if 'hard/' in path:
            to += '_hard'
        if not os.path.exists(to) or os.path.getmtime(to) < os.path.getmtime(path):
            more = ['-I.', '-DPDCORR_LINKED'] if path.startswith('drivers') else ['-DPDI_SPLIT', '-Isrc']
            status, _, out = self.call(self.cc + self.dev_test + ['-DPD_DIM=%d' % d, '-Itests', '-Itests/hard'] + more +
                                       [path, '-o', to, self.library(d), '-Wl,-rpath,' + os.path.abspath(self.dir), '-lm'])
            if status:
                print('mutants: %s does not build: %s' % (to, out.strip()[:300]))
                return None
        return to

    def command(self, test):
        path, d = test
        if path.endswith('.sh'):
            return ['sh', path]
        program = self.program(test)
        return [program] if program else None

    def run(self, test, limit):
        return self.call(self.command(test), limit, PROGRAMS=os.path.join(self.dir, 'programs'), BUILD=self.a.build)

    def sound(self, test):
        """It passes without a fault; the libraries are then those without one."""
        if test not in self.plain:
            for d in DIMS:
                self.link(d)
            fine = self.command(test) is not None
            status, took, _ = self.run(test, self.a.longest) if fine else (1, 0.0, '')
            self.plain[test] = status == 0
            if status:
                print('mutants: %s %s without a fault and is not used' %
                      (name_of(test), 'takes more than %g s' % self.a.longest if status == -1 else 'fails'))
        return self.plain[test]

    def remember(self, test, took):
        self.times[name_of(test)] = round(took, 2)
        json.dump(self.times, open(os.path.join(self.dir, 'times.json'), 'w'))


def name_of(test):
    return '%s %dD' % test if test[1] else test[0]


def all_tests(root):
    c, shell = [], []
    for folder in ('tests', 'tests/hard'):
        for name in sorted(os.listdir(os.path.join(root, folder))) if os.path.isdir(os.path.join(root, folder)) else ():
            path = os.path.join(folder, name)
            if re.match(r'test_\w+\.c$', name):
                slow = marked(path, 'slow', [])
                c += [(path, d) for d in marked(path, 'dims', [2]) if d not in slow]
            elif name.endswith('.sh') and folder == 'tests':
                text = open(path).read()
                if '$programs/' in text and 'slow: yes' not in text and not re.search(r'\$CC|chromedriver|valgrind', text):
                    shell.append((path, 0))
    return c, shell


def judge(m, graph, module, changed, tests, originals):
    """The test that sees the fault, or None; what it said, seconds spent and tests run."""
    c, shell = tests
    near = [(graph.distance(t[0], module), t) for t in c if t[1] in changed]

    def place(n):  # quick tests first, and 2D
        return 2 * n[0] + math.log2(1.0 + m.times.get(name_of(n[1]), 1.0)), abs(n[1][1] - 2), n[1]

    near += [(SHELL, t) for t in shell]
    order = [t for _, t in sorted((n for n in near if n[0] is not None), key=place)]
    total, used, linked = 0.0, 0, False
    for test in order:
        known = m.times.get(name_of(test))
        if total > m.a.seconds:
            break
        if m.plain.get(test) is False or (known or 0.0) > m.a.longest or m.command(test) is None:
            continue
        if not linked:
            for d in changed:
                m.link(d, originals[d])
            linked = True
        limit = m.a.longest if known is None else 5.0 + 5.0 * known
        status, took, out = m.run(test, limit)
        total += took
        used += 1
        if not status:
            m.remember(test, took)
            continue
        linked = linked and test in m.plain
        if m.sound(test):
            said = [line for line in out.splitlines() if not line.startswith('note') and re.search(r': \w+: |^failed: |assert|ERROR', line)]
            return name_of(test), (said or ['no end' if status == -1 else 'status %d' % status])[0].strip(), total, used
    return None, '', total, used


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument('--seed', type=int, help='of the faults; without: by the clock')
    p.add_argument('--count', type=int, default=100, help='faults with an effect')
    p.add_argument('--seconds', type=float, default=300, help='of processor time in tests for a fault, after which it has survived')
    p.add_argument('--longest', type=float, default=120, help='a test that takes more of them is not used')
    p.add_argument('--only', default='', help='folders or files below src, with commas between them')
    p.add_argument('--at', help='FILE:LINE: the faults of a line below src, one after the other')
    p.add_argument('--build', default='build')
    p.add_argument('--list', action='store_true', help='print the faults and stop')
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
    m, graph, tests = Machine(a), Graph('.'), all_tests('.')
    if not a.list:
        os.makedirs(os.path.join(m.dir, 'programs'), exist_ok=True)
        for d in DIMS:
            m.link(d)
            if os.path.exists('drivers/scene.c'):
                built = m.program(('drivers/scene.c', d))
                to = os.path.join(m.dir, 'programs', 'pd%dd' % d)
                if built and not os.path.exists(to):
                    os.symlink(os.path.abspath(built), to)
    drawn = built = effect = killed = survived = 0
    room = sum(len(f) for s in sources.values() for f in s[1].values())
    while (drawn if a.list or a.at else effect) < a.count and drawn < room:
        path, text, (x, y, new), kind = queue[drawn] if queue is not None else draw(sources, rng, seen)
        drawn += 1
        line = text.count('\n', 0, x) + 1
        changed_text = text[:x] + new + text[y:]
        old, now = (t.split('\n')[line - 1].strip() for t in (text, changed_text))
        head = 'src/%s:%d: %s' % (path, line, kind)
        diff = '%s\n    - %s\n    + %s' % (head, old, now)
        if '\n' in text[x:y]:
            diff += ' ... (the statement is left out)'
        if a.list:
            print(diff)
            continue
        source = os.path.join(m.dir, 'source', path)
        os.makedirs(os.path.dirname(source), exist_ok=True)
        open(source, 'w').write(changed_text)
        swaps, fine = {}, True
        for d in DIMS:
            to = os.path.join(m.dir, 'mutant%dd.o' % d)
            original = os.path.join(a.build, 'obj%dd' % d, path[:-2] + '.o')
            fine = fine and m.compile(source, d, to)[0]
            plain = os.path.join(m.dir, 'plain%dd.o' % d)
            # asserts hold the name of the source: compare with the original compiled from there, too
            open(source, 'w').write(text)
            if fine and m.compile(source, d, plain)[0] and not m.same(plain, to):
                swaps[d] = (original, to)
            open(source, 'w').write(changed_text)
        if not fine:
            continue
        built += 1
        if not swaps:
            print('%s: no effect' % head)
            continue
        effect += 1
        test, said, took, used = judge(m, graph, path[:-2], sorted(swaps), tests, swaps)
        if test:
            killed += 1
            print('%s: killed after %.0f s by test %d, %s: %s' % (head, took, used, test, said[:160]))
        else:
            survived += 1
            print('SURVIVED %d tests in %.0f s: %s' % (used, took, diff))
        sys.stdout.flush()
    print('%d mutants, %d built, %d with an effect, %d killed, %d survived' % (drawn, built, effect, killed, survived))


if __name__ == '__main__':
    main()
