#!/usr/bin/python3
"""Error against processor time and memory, beside other codes.

    peers.py [--only CASE]... [--code CODE]... [--build DIR] [--out DIR] [--repeat N] [--limit S]
    peers.py --report [--out DIR] [--docs DIR] [--readme FILE]
    peers.py --check [--only CASE]... [--build DIR] [--out DIR]
    peers.py --list

A case is a folder with a case.ini and one input file for each code. A code that is not installed is named and passed
over. Each file runs in an empty folder, on one thread, with a resolution as its argument, and prints lines

    peer KEY=VALUE KEY=VALUE ...

whose keys are the figures of the case. Runs of one resolution take turns, --repeat times; the least time counts. What
was measured is kept in OUT/CASE.csv, with what in OUT/machine.csv; --report writes DOCS/peers.md and its pictures from
there without a run, and leaves out cases that have no rows; what README.md has between two comments
<!-- peers --> are the figures that cases name for it. --check runs pdcorr alone, at the first resolution of each
case, and compares with what is kept.

case.ini:
    [case]            title, about; losses: why pdcorr is behind and what would mend it; skip: why a code is left out;
                      readme: figures of the table in README.md
    [figure KEY]      label; exact: value of the reference; source: where it comes from; error: relative (default),
                      absolute, cost (the value is a cost, there is no reference) or none (it is listed alone); unit
    [run NAME]        file; n: resolutions; label: what an expert of the code chose
"""
import argparse, configparser, csv, math, os, re, shutil, signal, subprocess, sys, tempfile, time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)

# Of a code: its name, the program that must be installed, Debian's package, how a file of it is run, its version.
CODES = {
    "pdcorr": ("pdcorr", None, None, ["sh", "{file}", "{n}"], None),
    "freefem": ("FreeFEM", "FreeFem++", "freefem++", ["FreeFem++", "-nw", "-v", "0", "{file}", "-n", "{n}"],
                "dpkg-query -W -f '${Version}' freefem++"),
    "openfoam": ("OpenFOAM", "simpleFoam", "openfoam", ["bash", "{file}", "{n}"],
                 "dpkg-query -W -f '${Version}' openfoam"),
    "lammps": ("LAMMPS", "lmp", "lammps", ["sh", "{file}", "{n}"], "dpkg-query -W -f '${Version}' lammps"),
    "calculix": ("CalculiX", "ccx", "calculix-ccx", ["/usr/bin/python3", "{file}", "{n}"],
                 "dpkg-query -W -f '${Version}' calculix-ccx"),
    "phreeqc": ("PHREEQC", "phreeqc", None, ["sh", "{file}", "{n}"],
                "strings -n 5 $(command -v phreeqc) | grep -m 1 -x '3[.][0-9][0-9.]*'"),
    "octave": ("Octave", "octave", "octave", ["octave", "--no-gui", "--quiet", "{file}", "{n}"],
               "dpkg-query -W -f '${Version}' octave"),
}
PACKAGES = "freefem++ openfoam lammps calculix-ccx octave time python3-matplotlib python3-numpy"


class Case:
    def __init__(self, name):
        self.name, self.folder = name, os.path.join(HERE, name)
        ini = configparser.ConfigParser(interpolation=None, delimiters=("=",), comment_prefixes=("#",))
        ini.optionxform = str
        with open(os.path.join(self.folder, "case.ini")) as f:
            ini.read_file(f)
        self.head = dict(ini["case"])
        self.figures = {s[7:]: dict(ini[s]) for s in ini.sections() if s.startswith("figure ")}
        self.runs = {s[4:]: dict(ini[s]) for s in ini.sections() if s.startswith("run ")}
        for run, of in self.runs.items():
            of["code"] = of.get("code", run.split()[0])
            if of["code"] not in CODES:
                sys.exit("%s: [run %s]: the code must be one of %s" % (name, run, ", ".join(sorted(CODES))))
            if not os.path.isfile(os.path.join(self.folder, of["file"])):
                sys.exit("%s: [run %s]: there is no file %s" % (name, run, of["file"]))

    def error(self, key, value):
        """|error| of a figure; without a reference it is the value."""
        figure = self.figures[key]
        how, exact = figure.get("error", "relative"), float(figure.get("exact", "nan"))
        if how in ("cost", "none"):
            return value
        return abs(value - exact) if how == "absolute" else abs(value / exact - 1.0)


def installed(code):
    return CODES[code][1] is None or shutil.which(CODES[code][1]) is not None


def version(code):
    how = CODES[code][4]
    return subprocess.run(how, shell=True, capture_output=True, text=True).stdout.strip() if how else ""


def machine(o):
    """What runs are made with: the processor and the versions of the codes."""
    found = {}
    with open("/proc/cpuinfo", errors="replace") as f:
        name = re.search(r"^model name\s*: (.*)$", f.read(), re.M)
    if name:
        found["processor"] = name.group(1)
    program = os.path.join(o.build, "pd2d")
    if os.path.isfile(program):
        found["pdcorr"] = subprocess.run([program, "--version"], capture_output=True, text=True).stdout.split()[-1]
    for code in CODES:
        if installed(code) and version(code):
            found[CODES[code][0]] = version(code)
    return found


def read_machine(out):
    path = os.path.join(out, "machine.csv")
    if not os.path.isfile(path):
        return {}
    with open(path, newline="") as f:
        return dict(row for row in csv.reader(f) if len(row) == 2)


def write_machine(o):
    kept = {**read_machine(o.out), **machine(o)}
    with open(os.path.join(o.out, "machine.csv"), "w", newline="") as f:
        csv.writer(f, lineterminator="\n").writerows(kept.items())


def measure(case, run, n, build, limit):
    """One run: seconds of the processor, largest resident memory in MB, what was printed; None and why on failure."""
    of = case.runs[run]
    words = [w.format(file=os.path.join(case.folder, of["file"]), n=n) for w in CODES[of["code"]][3]]
    env = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", PD=build, CASE=case.folder)
    with tempfile.TemporaryDirectory(prefix="peers_") as folder, tempfile.NamedTemporaryFile("r") as largest:
        log = os.path.join(folder, "peers.log")
        # The system counts the memory of this process as that of its children: a small process in between has less.
        if os.path.isfile("/usr/bin/time"):
            words = ["/usr/bin/time", "-q", "-o", largest.name, "-f", "%M"] + words
        with open(log, "w") as out:
            child = subprocess.Popen(words, cwd=folder, env=env, stdout=out, stderr=subprocess.STDOUT,
                                     stdin=subprocess.DEVNULL, start_new_session=True)
            begin = time.time()
            while True:
                pid, status, usage = os.wait4(child.pid, os.WNOHANG)
                if pid:
                    break
                if time.time() - begin > limit:
                    os.killpg(child.pid, signal.SIGKILL)
                time.sleep(0.002)
            child.returncode = status
        with open(log, errors="replace") as f:
            text = f.read()
        memory = float(largest.read() or usage.ru_maxrss) / 1024.0
    found = {}
    for line in re.findall(r"^\s*peer (.*)$", text, re.M):
        for word in line.split():
            key, _, value = word.partition("=")
            found[key] = float(value)
    missing = [k for k in case.figures if k not in found]
    if status or missing:
        tail = "\n".join(text.strip().splitlines()[-12:])
        return None, "status %d, figures missing: %s\n%s" % (status, ", ".join(missing) or "none", tail)
    return (usage.ru_utime + usage.ru_stime, memory, found), ""


def run_case(case, o):
    """All runs of a case, in turns; rows (run, n, cpu, memory, figures) into OUT/CASE.csv."""
    rows, failed = [], 0
    pairs = [(run, n) for run, of in case.runs.items() for n in of["n"].split()
             if installed(of["code"]) and (not o.code or of["code"] in o.code)]
    best = {}
    for turn in range(o.repeat):
        for run, n in sorted(pairs, key=lambda p: float(p[1].split(":")[0])):
            if best.get((run, n), ())  is None:
                continue
            # What takes long is known well after one turn.
            if turn and best[run, n][0] > 20.0:
                continue
            got, why = measure(case, run, n, o.build, o.limit)
            if got is None:
                print("%s %s n=%s FAILED: %s" % (case.name, run, n, why), flush=True)
                best[run, n], failed = None, failed + 1
                continue
            old = best.get((run, n))
            best[run, n] = got if old is None or got[0] < old[0] else old
            if turn == 0:
                print("result case=%s run=%s n=%s cpu_s=%.3g memory_MB=%.4g %s" % (
                    case.name, run.replace(" ", "_"), n, got[0], got[1],
                    " ".join("%s=%.8g err_%s=%.3g" % (k, got[2][k], k, case.error(k, got[2][k]))
                             for k in case.figures)), flush=True)
    kept = {}
    path = os.path.join(o.out, case.name + ".csv")
    if o.code and os.path.isfile(path):
        for row in read_rows(case, o.out):
            kept[row["run"], row["n"]] = row
    for (run, n), got in best.items():
        if got is not None:
            kept[run, n] = dict(run=run, n=n, cpu_s="%.4g" % got[0], memory_MB="%.4g" % got[1],
                                **{k: "%.10g" % got[2][k] for k in case.figures})
    os.makedirs(o.out, exist_ok=True)
    order = {(run, n): k for k, (run, n) in enumerate((r, m) for r, of in case.runs.items() for m in of["n"].split())}
    with open(path + ".new", "w", newline="") as f:
        w = csv.DictWriter(f, ["run", "n", "cpu_s", "memory_MB"] + list(case.figures), lineterminator="\n")
        w.writeheader()
        for key in sorted((k for k in kept if k in order), key=order.get):
            w.writerow(kept[key])
    os.replace(path + ".new", path)
    return failed


def check(cases, o):
    """Each run of pdcorr at its first resolution gives the figures that are kept; costs are not compared."""
    passed = failed = 0
    for case in cases:
        rows = read_rows(case, o.out)
        for run, of in case.runs.items():
            kept = [r for r in rows if r["run"] == run and r["n"] == of["n"].split()[0]]
            if of["code"] != "pdcorr" or (o.only and case.name not in o.only):
                continue
            got, why = measure(case, run, of["n"].split()[0], o.build, o.limit)
            far = [] if got is None or not kept else [
                "%s: %.10g, kept %s" % (k, got[2][k], kept[0][k]) for k in case.figures
                if case.figures[k].get("error") != "cost" and
                abs(got[2][k] - float(kept[0][k])) > 1e-6 * abs(float(kept[0][k]))]
            if got is None or not kept or far:
                print("failed: %s, %s: %s" % (case.name, run, why or ", ".join(far) or "nothing is kept"))
                failed += 1
            else:
                passed += 1
    print("%d passed, %d failed" % (passed, failed))
    return failed


def read_rows(case, out):
    path = os.path.join(out, case.name + ".csv")
    if not os.path.isfile(path):
        return []
    with open(path, newline="") as f:
        return [r for r in csv.DictReader(f) if r["run"] in case.runs and all(r.get(k) for k in case.figures)]


def curve(case, rows, run, key, cost="cpu_s"):
    """(cost, error) of the resolutions of a run."""
    return [(float(r[cost]), case.error(key, float(r[key]))) for r in rows if r["run"] == run]


def frontier(points):
    """The efficient part of points (cost, error): each costs more and errs less than the one before."""
    kept = []
    for cost, error in sorted(points):
        if not kept or error < kept[-1][1]:
            kept.append((cost, max(error, 1e-16)))
    return kept


def cost_at(front, error):
    """Cost of a frontier at an error, between points by the logarithm; None where it does not reach the error."""
    if not front or error < front[-1][1]:
        return None
    if error >= front[0][1]:
        return front[0][0]
    for (c0, e0), (c1, e1) in zip(front, front[1:]):
        if error >= e1:
            t = math.log(error / e0) / math.log(e1 / e0)
            return math.exp(math.log(c0) + t * math.log(c1 / c0))


EQUAL = 1.05 # factors below it are noise of the clock


def times(low, high):
    """Factors from low to high by which pdcorr is ahead (above 1) or behind, in words."""
    def side(ratio):
        return "ahead" if ratio >= EQUAL else "**behind**" if ratio <= 1.0 / EQUAL else "equal"

    def factor(ratio):
        return "%g" % float("%.2g" % max(ratio, 1.0 / ratio))

    if side(low) == side(high):
        if side(low) == "equal":
            return "equal"
        both = list(dict.fromkeys(sorted((factor(low), factor(high)), key=float)))
        return "%s times %s" % (" to ".join(both), side(low))
    return " to ".join("equal" if side(r) == "equal" else "%s times %s" % (factor(r), side(r)) for r in (low, high))


def verdict(case, rows, key, code):
    """Best of pdcorr beside the best of another code at equal error: least and largest factor by which pdcorr is ahead,
    0 or infinity where one of them alone reaches an error, and words."""
    def best(of):
        return frontier([p for run in case.runs if case.runs[run]["code"] == of for p in curve(case, rows, run, key)])
    ours, theirs = best("pdcorr"), best(code)
    if not ours or not theirs or case.figures[key].get("error") == "none":
        return None
    if case.figures[key].get("error") == "cost":
        ratio = min(e for _, e in theirs) / min(e for _, e in ours)
        return ratio, ratio, times(ratio, ratio)
    ratios = [cost_at(theirs, error) / cost_at(ours, error) for _, error in ours + theirs
              if error <= min(ours[0][1], theirs[0][1]) and error >= max(ours[-1][1], theirs[-1][1])]
    if not ratios:
        if ours[0][1] < theirs[-1][1]:
            return math.inf, math.inf, "pdcorr errs less at every point"
        return 0.0, 0.0, "**behind**: %s errs less at every point" % CODES[code][0]
    low, high = min(ratios), max(ratios)
    text = times(low, high)
    if theirs[-1][1] < ours[-1][1]:
        return low, high, text + "; %s alone reaches %.2g" % (CODES[code][0], theirs[-1][1])
    if ours[-1][1] < theirs[-1][1]:
        text += "; pdcorr alone reaches %.2g" % ours[-1][1]
    return low, high, text


COLOURS = {"pdcorr": "#c0392b", "freefem": "#2c6fbb", "openfoam": "#27834a", "lammps": "#8e44ad",
           "calculix": "#b8860b", "phreeqc": "#16808a", "octave": "#555555"}


def draw(case, rows, path):
    """A row of pictures a figure: error against time and against memory. A case of costs alone: each against n."""
    import matplotlib
    matplotlib.use("agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import LogFormatter

    class Plain(LogFormatter):
        def __call__(self, x, pos=None):
            return "%g" % x if super().__call__(x, pos) else ""

    plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    keys = [k for k, of in case.figures.items() if of.get("error") not in ("cost", "none")]
    costs = [k for k, of in case.figures.items() if of.get("error") == "cost"]
    if keys:
        sides = (("cpu_s", "processor time [s]"), ("memory_MB", "memory [MB]"))
        panels = [(key, side) for key in keys for side in sides]
    else:
        panels = [(key, ("n", "n")) for key in costs]
    down = (len(panels) + 1) // 2
    height = 2.7 * down + 0.8
    fig, axes = plt.subplots(down, 2, figsize=(9.0, height), squeeze=False, sharey="row" if keys else False)
    marks, styles = "osD^v", ["-", "--", ":", "-."]
    for ax, (key, (cost, label)) in zip(axes.flat, panels):
        of, seen, largest, least = case.figures[key], {}, 0.0, math.inf
        for run in case.runs:
            if cost == "n":
                points = [(float(r["n"].split(":")[0]), float(r[key])) for r in rows if r["run"] == run]
            else:
                points = curve(case, rows, run, key, cost)
            if not points:
                continue
            code = case.runs[run]["code"]
            k = seen[code] = seen.get(code, -1) + 1
            values = [max(e, 1e-16) for _, e in points]
            largest, least = max([largest] + values), min([least] + values)
            ax.plot([c for c, _ in points], values, styles[k % 4], marker=marks[k % 5], ms=4.5, lw=1.4,
                    color=COLOURS[code], label=name_of(case, run))
        ax.set_xlabel(label)
        ax.grid(True, which="major", color="0.9", lw=0.7)
        name, unit = of.get("label", key), " [%s]" % of["unit"] if of.get("unit") else ""
        if cost == "n":
            ax.set_title(name + unit, fontsize=9, loc="left")
            if largest > 10.0 * least:
                ax.set_yscale("log")
                ax.yaxis.set_major_formatter(Plain())
            else:
                ax.set_ylim(0.0, 1.1 * largest)
            continue
        ax.set_xscale("log")
        ax.set_yscale("log")
        for which in (ax.xaxis.set_major_formatter, ax.xaxis.set_minor_formatter):
            which(Plain(minor_thresholds=(1.2, 0.5)))
        if cost == "cpu_s":
            absolute = of.get("error") == "absolute"
            ax.set_ylabel("%s\n%s" % (name, "error" + unit if absolute else "relative error"))
    for ax in list(axes.flat)[len(panels):]:
        ax.set_visible(False)
    handles, labels = axes[0][0].get_legend_handles_labels()
    lines = (len(labels) + 3) // 4
    fig.suptitle(case.head["title"], x=0.02, ha="left", fontsize=11)
    fig.legend(handles, labels, loc="lower center", ncol=min(4, max(1, len(labels))), frameon=False)
    fig.tight_layout(rect=(0, (0.13 + 0.2 * lines) / height, 1, 1.0))
    fig.savefig(path, metadata={"Software": None}, dpi=100)
    plt.close(fig)


def name_of(case, run):
    """A run as readers see it: the code, and what is special."""
    code = case.runs[run]["code"]
    return " ".join([CODES[code][0]] + [w for w in run.split() if w != code])


def summary(measured):
    """The tables of all cases: where pdcorr is behind, the worst first, then where it is ahead."""
    table = []
    for case, rows in measured:
        for code in dict.fromkeys(of["code"] for of in case.runs.values() if of["code"] != "pdcorr"):
            for key, of in case.figures.items():
                found = verdict(case, rows, key, code)
                if found:
                    table.append(found[:2] + ("| [%s](#%s): %s | %s | %s |" % (
                        case.head["title"], case.name, of.get("label", key), CODES[code][0], found[2]),))
    table.sort(key=lambda row: row[:2])
    parts = (("Behind", [r for r in table if r[1] <= 1.0 / EQUAL]),
             ("Behind at some errors", [r for r in table if r[0] <= 1.0 / EQUAL < r[1]]),
             ("Ahead or equal", [r for r in table if r[0] > 1.0 / EQUAL]))
    lines = ["%d comparisons at equal error, by processor time: pdcorr is behind in %d, behind at some errors in %d, "
             "ahead or equal in %d." % ((len(table),) + tuple(len(part) for _, part in parts))]
    for title, part in parts:
        if part:
            lines += ["", "## " + title, "", "| figure | beside | pdcorr |", "|---|---|---|"] + [r[2] for r in part]
    return lines


def readme(measured, path):
    """The figures that cases name for it, between two comments of that file."""
    lines = ["| case | figure | beside | pdcorr at equal error, by processor time |", "|---|---|---|---|"]
    for case, rows in measured:
        for key in case.head.get("readme", "").split():
            for code in dict.fromkeys(of["code"] for of in case.runs.values() if of["code"] != "pdcorr"):
                found = verdict(case, rows, key, code)
                if found:
                    lines.append("| [%s](docs/peers.md#%s) | %s | %s | %s |" % (
                        case.head["title"], case.name, case.figures[key].get("label", key), CODES[code][0], found[2]))
    mark = "<!-- peers -->"
    with open(path) as f:
        parts = f.read().split(mark)
    if len(parts) != 3:
        sys.exit("%s: expected two comments %s, found %d" % (path, mark, len(parts) - 1))
    with open(path, "w") as f:
        f.write(mark.join([parts[0], "\n\n" + "\n".join(lines) + "\n\n", parts[2]]))


def section(case, rows):
    """A case: what it is, its picture, figures, settings, why pdcorr is behind, all rows."""
    lines = ["", '<a id="%s"></a>' % case.name, "", "## " + case.head["title"], "", case.head.get("about", ""), "",
             "![%s](img/peers/%s.png)" % (case.head["title"], case.name), "", "Figures:", ""]
    for key, of in case.figures.items():
        unit = " " + of["unit"] if of.get("unit") else ""
        if of.get("error") in ("cost", "none"):
            lines.append("- %s%s" % (of.get("label", key), unit and "," + unit))
        else:
            lines.append("- %s; reference %s%s: %s" % (of.get("label", key), of["exact"], unit, of.get("source", "")))
    lines += ["", "Settings:", ""]
    for run, of in case.runs.items():
        if any(r["run"] == run for r in rows):
            path = os.path.relpath(os.path.join(case.folder, of["file"]), os.path.join(ROOT, "docs"))
            lines.append("- %s: %s ([`%s`](%s))" % (name_of(case, run), of.get("label", "n"), os.path.basename(path),
                                                    path))
    if case.head.get("losses"):
        lines += ["", "Where pdcorr is behind: " + case.head["losses"]]
    heads = ["%s%s" % (of.get("label", key), ", error" if of.get("error") not in ("cost", "none") else
                       " [%s]" % of["unit"] if of.get("unit") else "") for key, of in case.figures.items()]
    lines += ["", "| code | n | time [s] | memory [MB] | " + " | ".join(heads) + " |",
              "|---|---|" + "---:|" * (2 + len(heads))]
    for r in rows:
        values = [("%.2g" if of.get("error") not in ("cost", "none") else "%.4g") % case.error(key, float(r[key]))
                  for key, of in case.figures.items()]
        lines.append("| %s | %s | %.3g | %.3g | %s |" % (name_of(case, r["run"]), r["n"].replace(":", ", "),
                                                        float(r["cpu_s"]), float(r["memory_MB"]), " | ".join(values)))
    return lines


def report(cases, o):
    """DOCS/peers.md: losses first, then a section a case with its picture and all rows."""
    measured = [(case, read_rows(case, o.out)) for case in cases]
    measured = [(case, rows) for case, rows in measured if rows]
    if not measured:
        sys.exit("%s has no rows: nothing to report" % o.out)
    pictures = os.path.join(o.docs, "img", "peers")
    os.makedirs(pictures, exist_ok=True)
    for name in os.listdir(pictures):
        if name.endswith(".png") and name[:-4] not in [case.name for case, _ in measured]:
            os.remove(os.path.join(pictures, name))
    for case, rows in measured:
        draw(case, rows, os.path.join(pictures, case.name + ".png"))
    used = {CODES[of["code"]][0] for case, rows in measured for run, of in case.runs.items()
            if any(r["run"] == run for r in rows)}
    made = {name: what for name, what in read_machine(o.out).items() if name in used | {"processor"}}
    lines = ["# Beside other codes", "",
             "What does a figure cost here, and what does it cost with a code that a user would take instead? "
             "`make peers` runs both on one machine, on one thread, in turns, and draws error against processor time and "
             "memory. References are closed forms, published values, or finer than every point drawn. Input files, settings "
             "included, are in [peers](../peers): a folder a case, a file a code.", ""]
    if made:
        lines += ["Measured on: %s. Versions: %s." % (made.pop("processor", "an unknown processor"),
                                                      ", ".join("%s %s" % item for item in made.items())), ""]
    lines += summary(measured)
    for case, rows in measured:
        lines += section(case, rows)
    with open(os.path.join(o.docs, "peers.md"), "w") as f:
        f.write("\n".join(lines) + "\n")
    readme(measured, o.readme)


def main():
    p = argparse.ArgumentParser(usage=__doc__)
    p.add_argument("--only", action="append", default=[])
    p.add_argument("--code", action="append", default=[])
    p.add_argument("--build", default=os.path.join(ROOT, "build"))
    p.add_argument("--out", default=os.path.join(HERE, "measured"))
    p.add_argument("--docs", default=os.path.join(ROOT, "docs"))
    p.add_argument("--readme", default=os.path.join(ROOT, "README.md"))
    p.add_argument("--repeat", type=int, default=2)
    p.add_argument("--limit", type=float, default=600.0)
    p.add_argument("--report", action="store_true")
    p.add_argument("--list", action="store_true")
    p.add_argument("--check", action="store_true")
    o = p.parse_args()
    o.build = os.path.abspath(o.build)
    names = sorted(d for d in os.listdir(HERE) if os.path.isfile(os.path.join(HERE, d, "case.ini")))
    for name in o.only:
        if name not in names:
            p.error("there is no case %s (--list prints them)" % name)
    cases = [Case(n) for n in names]
    if o.list:
        for case in cases:
            print("%-20s %-60s %s" % (case.name, case.head["title"], ", ".join(case.runs)))
        return 0
    if o.check:
        return 1 if check(cases, o) else 0
    failed = 0
    if not o.report:
        absent = [CODES[c][0] for c in CODES if not installed(c)]
        if absent:
            print("not installed, passed over: %s; all of Debian's at once: apt-get install --no-install-recommends %s"
                  % (", ".join(absent), PACKAGES), flush=True)
        for case in cases:
            if not o.only or case.name in o.only:
                failed += run_case(case, o)
        write_machine(o)
    report(cases, o)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
