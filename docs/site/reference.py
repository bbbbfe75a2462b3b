"""Pages that come from the sources: scene keys (pd2d --keys) and the public parts of pdcorr.h and pdcorr_app.h."""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "drivers" / "python"))
import declare  # noqa: E402  pylint: disable=wrong-import-position

ROOMS = {
    "core": "what everything else stands on", "lattice": "where things are", "solve": "how equations are solved",
    "flow": "how the fluid moves", "chemistry": "what species and reactions come to",
    "transport": "how what is dissolved moves", "react": "how species move and react",
    "solid": "how metal bears loads", "metal": "how metal dissolves", "potential": "electric currents around metals",
    "couple": "all of it together, in time", "io": "files and pictures",
    "setup": "a simulation as data", "physics": "what each physics of a setup builds",
    "scene": "scene files", "run": "whole runs",
}


def escape(text: str) -> str:
    """Plain words as Markdown."""
    return re.sub(r"([\\*_\[\]<>|#$`~])", r"\\\1", text)


# ---- scene keys
def keys(program: Path) -> str:
    """The table of keys that the parser itself has, a section after the other."""
    def said(*arguments: str) -> list[str]:
        done = subprocess.run([str(program), "--keys", *arguments], check=True, capture_output=True, text=True)
        return done.stdout.splitlines()

    lines = [
        "# Scene reference", "",
        f"Every section and key of a scene file, as `{program.name} --keys` prints them: the table that the parser reads",
        "by. The [guide](guide.md#2-scene-files) has the same keys with what belongs together explained.", "",
    ]
    for line in said():
        head, meaning = re.fullmatch(r"(\[.*?\])\s+(.*)", line).groups()
        lines += [f"## `{head}`", "", escape(meaning) + ".", ""]
        lines += ["| key | meaning | unit | default |", "|---|---|---|---|"]
        row: list[str] = []
        for text in [*said(head[1:-1].split()[0])[1:], "  end unit - default -"]:
            key = re.fullmatch(r"  (\S.*?)\s+unit (.*?)\s+(required.*|default .*)", text)
            if key:
                if row:
                    cells = [row[0], escape(" ".join(row[3:])), escape(row[1]), escape(row[2])]
                    lines += ["| " + " | ".join(cells) + " |"]
                names = ", ".join(f"`{name}`" for name in key.group(1).split(", "))
                row = [names, key.group(2), key.group(3).removeprefix("default ")]
            elif text.strip():
                row.append(text.strip())
        lines += [""]
    return "\n".join(lines)


# ---- the headers
INLINE = ("static inline ", "PDI_INLINE ")
DIRECTIVE = re.compile(r"#\s*(if|endif|else|elif|include|error|undef)|#define \w+ PD_NAME\(|#define \w+_H$")


def public(text: str) -> str:
    """Without what is internal, and without the names that carry the dimension."""
    kept, depth, hidden = [], 0, 0
    for line in text.splitlines():
        if re.match(r"#\s*if", line):
            depth += 1
            if not hidden and "PDI_INTERNAL" in line:
                hidden = depth
        if not hidden and not DIRECTIVE.match(line):
            kept.append(line)
        if re.match(r"#\s*endif", line):
            if hidden == depth:
                hidden = 0
            depth -= 1
    return "\n".join(kept)


def pieces(text: str):
    """(comment, declaration) of a module, in order; the first comment is that of the module."""
    token = re.compile(r"/\*.*?\*/|\"(?:[^\"\\]|\\.)*\"|[{}();]|\n|[^/\"{}();\n]+|.", re.S)
    comment, code, depth = "", "", 0
    for match in token.finditer(text):
        part = match.group()
        if part.startswith("/*") and not code.strip():
            if comment:
                yield comment, ""
            comment, code = part, ""
            continue
        if part.startswith("#") and not code.strip():
            depth = -1  # a macro ends with its line
        if part == "\n" and depth == -1:
            if code.rstrip().endswith("\\"):
                code += part
                continue
            yield comment, code.strip()
            comment, code, depth = "", "", 0
            continue
        code += part
        if depth < 0:
            continue
        depth += (part in "{(") - (part in "})")
        inline = code.lstrip().startswith(INLINE)
        if depth == 0 and part == ("}" if inline else ";"):
            yield comment, code.strip()
            comment, code = "", ""
    if comment:
        yield comment, ""


def words(comment: str) -> str:
    """Text of a comment, paragraphs kept."""
    body = re.sub(r"^/\*+ ?|\s*\*/$", "", comment)
    return "\n".join(re.sub(r"^ ?\* ?", "", line) if k else line for k, line in enumerate(body.splitlines()))


class Header:
    """The public part of the header as pages, one for each room."""

    def __init__(self) -> None:
        texts = [(ROOT / name).read_text(encoding="utf-8") for name in ("pdcorr.h", "pdcorr_app.h")]
        order = (ROOT / "src" / "MODULES").read_text(encoding="utf-8").splitlines()
        self.rooms = [line.split()[0] for line in order if line and line.split()[0] in ROOMS]
        self.modules: dict[str, list[tuple[str, str, list[tuple[str, str]]]]] = {room: [] for room in self.rooms}
        self.names: dict[str, str] = {}
        declared = "".join(text.split("/* ======== >>internal")[0] for text in texts)
        interface = re.split(r"^/\* ======== >>(\w+)/(\w+)\.h ======== \*/$", declared, flags=re.M)
        for room, module, text in zip(interface[1::3], interface[2::3], interface[3::3]):
            found = [(c, d) for c, d in pieces(public(text)) if "extern \"C\"" not in d]
            intro = words(found[0][0]) if found and found[0][0] else ""
            found = [(c if k else "", d) for k, (c, d) in enumerate(found)]
            found = [(c, d) for c, d in found if d and self.name(d)]
            once: dict[str, tuple[str, str]] = {}  # a macro may have a form for each compiler
            for c, d in found:
                once.setdefault(self.name(d), (c, d))
            found = list(once.values())
            for _, declaration in found:
                for name in [self.name(declaration), *re.findall(r"\b(PD_[A-Z0-9_]+)\b", declaration)]:
                    self.names.setdefault(name, self.name(declaration))
            if found:
                self.modules[room].append((module, intro, found))
        self.check()

    @staticmethod
    def name(declaration: str) -> str:
        """What is declared; nothing for what is not public."""
        for pattern in (r"(?:PD_API|static inline|PDI_INLINE) [^(]*?\b(pd_\w+)\(",
                        r"typedef .*?\(\*(pd_\w+)\)\(", r"\}\s*(pd_\w+);$",
                        r"^struct (pd_\w+) \{", r"#define (PD_\w+)", r"^typedef [\w ]*?\b(pd_\w+);$",
                        r"^enum \{ *(PD_\w+)"):
            match = re.search(pattern, declaration, re.S)
            if match:
                return match.group(1)
        return ""

    def check(self) -> None:
        """Every function and structure that the compiler sees is there."""
        unit = declare.Unit(2)
        found = {self.name(d) for modules in self.modules.values() for _, _, items in modules for _, d in items}
        lost = [name for name in [*unit.functions, *unit.structs] if name not in found]
        if lost:
            raise ValueError(f"not on any page of the API: {', '.join(lost)}")

    def linked(self, text: str) -> str:
        """Markdown of a comment; names that are on a page lead there."""
        def name(match: re.Match) -> str:
            target = self.names.get(match.group())
            return f"[`{match.group()}`]({target})" if target else f"`{match.group()}`"

        parts = re.split(r"(`[^`]+`|\bpd_\w+|\bPD_[A-Z0-9_]+\b)", text)
        return "".join(p if p[:1] == "`" else name(re.match(".*", p)) if k % 2 else escape(p)
                       for k, p in enumerate(parts))

    def intro(self, text: str) -> list[str]:
        """The comment of a module: paragraphs, and lines that are set apart as they are."""
        return ["" if not p else self.linked(p) for p in text.splitlines()]

    def page(self, room: str) -> str:
        lines = [f"# {room}: {ROOMS[room]}", ""]
        for module, intro, items in self.modules[room]:
            intro = re.sub(rf"^{module}: (.)", lambda match: match.group(1).upper(), intro)
            lines += [f"## {module}", "", *self.intro(intro), ""]
            for comment, declaration in items:
                name = self.name(declaration)
                lines += [f"({name})=", f"### `{name}`", ""]
                code = re.sub(r"^(PD_API|PDI_INLINE) ", "", declaration)
                if declaration.startswith(INLINE):
                    code = re.sub(r"\s*\{.*", ";", code, flags=re.S)  # what it does is no part of the interface
                lines += ["```c", code, "```", "", *self.intro(words(comment)), ""]
        return "\n".join(lines)

    def index(self) -> str:
        lines = [
            "# C interface", "",
            "What `pdcorr.h` and `pdcorr_app.h` declare, from their comments, a page for each room. Names carry the dimension",
            "when they are linked: `pd_grid_build` is `pd_grid_build_2d` with `PD_DIM` 2. How to begin:",
            "[embedding](guide.md#6-embedding).", "",
            "| room | what | modules |", "|---|---|---|",
        ]
        for room in self.rooms:
            if self.modules[room]:
                names = ", ".join(f"[{m}](api/{room}.md#{m})" for m, _, _ in self.modules[room])
                lines.append(f"| [{room}](api/{room}.md) | {ROOMS[room]} | {names} |")
        return "\n".join(lines) + "\n"
