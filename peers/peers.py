#!/usr/bin/python3
"""Error against processor time and memory, beside other codes.

    peers.py [--only CASE]... [--code CODE]... [--build DIR] [--out DIR] [--repeat N] [--limit S] [--report] [--list] [--check]

A case is a folder with a case.ini and one input file for each code. A code that is not installed is named and passed
over. Each file runs in an empty folder, on one thread, with a resolution as its argument, and prints lines

    peer KEY=VALUE KEY=VALUE ...

whose keys are the figures of the case. Runs of one resolution take turns, --repeat times; the least time counts. What
was measured is kept in OUT/CASE.csv; --report draws docs/peers.md and its pictures from there without a run. --check
runs pdcorr alone, at the first resolution of each case, and compares with what is kept.

case.ini:
    [case]            title, about; losses: why pdcorr is behind and what would mend it; skip: why a code is left out
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
    "phreeqc": ("PHREEQC", "phreeqc", None, ["sh", "{file}", "{n}"], None),
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


def measure(case, run, n, build, limit):
    """One run: seconds of the processor, largest resident memory in MB, and what was printed; None and why on failure."""
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
        w = csv.DictWriter(f, ["run", "n", "cpu_s", "memory_MB"] + list(case.figures))
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


def verdict(case, rows, key, code):
    """Best of pdcorr beside the best of another code: how many times less time at equal error, as text."""
    def best(of):
        return frontier([p for run in case.runs if case.runs[run]["code"] == of for p in curve(case, rows, run, key)])
    ours, theirs = best("pdcorr"), best(code)
    if not ours or not theirs or case.figures[key].get("error") == "none":
        return ""
    if case.figures[key].get("error") == "cost":
        ratio = min(e for _, e in theirs) / min(e for _, e in ours)
        return "%.2g times %s" % (max(ratio, 1.0 / ratio), "ahead" if ratio >= 1.0 else "**behind**")
    ratios = []
    for _, error in ours:
        if cost_at(theirs, error) and error <= theirs[0][1]:
            ratios.append(cost_at(theirs, error) / cost_at(ours, error))
    for _, error in theirs:
        if cost_at(ours, error) and error <= ours[0][1]:
            ratios.append(cost_at(theirs, error) / cost_at(ours, error))
    if not ratios:
        return "%s is the more exact at every point" % ("pdcorr" if ours[0][1] < theirs[-1][1] else CODES[code][0])
    low, high = min(ratios), max(ratios)
    text = " to ".join(dict.fromkeys("%.2g times %s" % (max(r, 1.0 / r), "ahead" if r >= 1.0 else "**behind**")
                                     for r in (low, high)))
    if theirs[-1][1] < ours[-1][1]:
        text += "; below %.2g only %s" % (ours[-1][1], CODES[code][0])
    elif ours[-1][1] < theirs[-1][1]:
        text += "; below %.2g only pdcorr" % theirs[-1][1]
    return text


def draw(case, rows, path):
    import matplotlib
    matplotlib.use("svg" if path.endswith("svg") else "agg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"svg.hashsalt": "pdcorr", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    keys = [k for k in case.figures if case.figures[k].get("error") not in ("cost", "none")] or \
        [k for k in case.figures if case.figures[k].get("error") == "cost"]
    height = 3.1 * len(keys) + 0.6
    fig, axes = plt.subplots(len(keys), 2, figsize=(9.0, height), squeeze=False, sharey="row")
    runs = [r for r in case.runs if any(row["run"] == r for row in rows)]
    colours = {"pdcorr": "#c0392b", "freefem": "#2c6fbb", "openfoam": "#27834a", "lammps": "#8e44ad",
               "calculix": "#b8860b", "phreeqc": "#16808a", "octave": "#555555"}
    marks, styles = "osD^v", ["-", "--", ":", "-."]
    for i, key in enumerate(keys):
        of = case.figures[key]
        for j, (cost, label) in enumerate((("cpu_s", "processor time [s]"), ("memory_MB", "memory [MB]"))):
            ax, seen = axes[i][j], {}
            for run in runs:
                code = case.runs[run]["code"]
                k = seen[code] = seen.get(code, -1) + 1
                points = curve(case, rows, run, key, cost)
                ax.loglog([c for c, _ in points], [max(e, 1e-16) for _, e in points], styles[k % 4], marker=marks[k % 5],
                          ms=4.5, lw=1.4, color=colours[code], label=run if code != "pdcorr" else run)
            ax.set_xlabel(label)
            ax.grid(True, which="major", color="0.9", lw=0.7)
            if j == 0:
                how = of.get("error", "relative")
                ax.set_ylabel("%s\n%s" % (of.get("label", key), {"cost": of.get("unit", ""), "relative": "relative error",
                                                                 "absolute": "error " + of.get("unit", "")}[how]))
    handles, labels = axes[0][0].get_legend_handles_labels()
    fig.suptitle(case.head["title"], x=0.02, ha="left", fontsize=11)
    fig.legend(handles, labels, loc="lower center", ncol=min(4, max(1, len(labels))), frameon=False)
    fig.tight_layout(rect=(0, (0.13 + 0.2 * ((len(labels) + 3) // 4)) / height, 1, 0.99))
    fig.savefig(path, metadata={"Date": None} if path.endswith("svg") else {"Software": None}, dpi=110)
    plt.close(fig)


def report(cases, o):
    """docs/peers.md: losses first, then a section a case with its picture and all rows."""
    lines, table, losses = [], [], []
    versions = ["%s %s" % (CODES[c][0], version(c)) for c in CODES if CODES[c][4] and installed(c)]
    for case in cases:
        rows = read_rows(case, o.out)
        if not rows:
            continue
        draw(case, rows, os.path.join(ROOT, "docs", "img", "peers_%s.png" % case.name))
        codes = list(dict.fromkeys(of["code"] for of in case.runs.values() if of["code"] != "pdcorr"))
        lines += ["", "## " + case.head["title"], "", case.head.get("about", ""), "",
                  "![%s](img/peers_%s.png)" % (case.head["title"], case.name), ""]
        for key, of in case.figures.items():
            label = of.get("label", key)
            source = " Reference: %s%s, %s." % (of["exact"], " " + of["unit"] if of.get("unit") else "",
                                               of.get("source", "")) if of.get("exact") else ""
            for code in codes:
                text = verdict(case, rows, key, code)
                if text:
                    table.append(("behind" in text or "only " + CODES[code][0] in text or
                                  CODES[code][0] + " is the more" in text, case, label, CODES[code][0], text))
            lines += ["- %s.%s" % (label, source)]
        if case.head.get("losses"):
            lines += ["", "Where pdcorr is behind: " + case.head["losses"]]
        lines += ["", "| code | settings | n | time [s] | memory [MB] | " +
                  " | ".join("%s, error" % of.get("label", k) if of.get("error") not in ("cost", "none") else
                             "%s [%s]" % (of.get("label", k), of.get("unit", "")) for k, of in case.figures.items()) + " |",
                  "|---|---|" + "---:|" * (3 + len(case.figures))]
        for r in rows:
            lines.append("| %s | %s | %s | %s | %s | %s |" % (
                r["run"], case.runs[r["run"]].get("label", ""), r["n"], "%.3g" % float(r["cpu_s"]),
                "%.3g" % float(r["memory_MB"]),
                " | ".join(("%.4g" if of.get("error") == "none" else "%.2g") % case.error(k, float(r[k]))
                           for k, of in case.figures.items())))
    head = ["# Beside other codes", "",
            "What does a figure cost here, and what does it cost with a code that a user would take instead? `make peers` "
            "runs both on one machine, on one thread, in turns, and draws error against processor time and memory. "
            "References are closed forms, published values, or finer than every point drawn.", "",
            "Input files, settings included, are in [peers](../peers): a folder a case, a file a code.", "",
            "Versions: " + "; ".join(versions) + ".", "",
            "| case | figure | beside | at equal error, by processor time |", "|---|---|---|---|"]
    for bad in (True, False):
        for is_bad, case, label, code, text in table:
            if is_bad == bad:
                anchor = re.sub(r"[^a-z0-9 -]", "", case.head["title"].lower()).replace(" ", "-")
                head.append("| [%s](#%s) | %s | %s | %s |" % (case.head["title"], anchor, label, code, text))
    with open(os.path.join(ROOT, "docs", "peers.md"), "w") as f:
        f.write("\n".join(head + lines) + "\n")


def main():
    p = argparse.ArgumentParser(usage=__doc__)
    p.add_argument("--only", action="append", default=[])
    p.add_argument("--code", action="append", default=[])
    p.add_argument("--build", default=os.path.join(ROOT, "build"))
    p.add_argument("--out", default=os.path.join(HERE, "measured"))
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
    report(cases, o)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
