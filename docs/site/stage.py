"""Stages the pages of the site: the texts of docs/ as they are, and pages that come from the sources.

    python3 docs/site/stage.py FOLDER [--build BUILD] [--katex FOLDER]

What readers do not see on other pages neither (HTML comments) goes out, equations become LaTeX, links to files of the
repository lead to copies of them.
"""
import argparse
import os
import re
import shutil
from pathlib import Path

import equations
import reference

ROOT = reference.ROOT
DOCS = ROOT / "docs"
WITH_EQUATIONS = ("theory.md", "crevice.md") # and the chapters of theory/
PROJECT = {"contributing.md": ".github/CONTRIBUTING.md", "conduct.md": ".github/CODE_OF_CONDUCT.md",
           "security.md": ".github/SECURITY.md", "changes.md": "CHANGELOG.md"}
GENERATED = ("keys.md", "api.md", "gallery.md")
CONTENTS = [
    ("Begin", ["start", "tutorials/wire", "tutorials/pit", "tutorials/crevice", "tutorials/crack", "tutorials/python",
               "tutorials/browser", "tutorials/program", "gallery"]),
    ("Use", ["guide", "keys", "api"]),
    ("Understand", ["theory", "cracks", "crevice", "decisions", "architecture", "constants"]),
    ("Reports", ["validation", "performance", "stability", "peers", "Validation, all figures <details/validation>",
                 "Mechanics, all figures <details/mechanics>", "Performance, all figures <details/performance>",
                 "Stability, all figures <details/stability>"]),
    ("Project", ["contributing", "conduct", "security", "changes"]),
]


class Site:
    def __init__(self, folder: Path, build: Path):
        self.folder, self.build = folder, build
        self.anchors = {
            path: set(re.findall(r'^<a id="([^"]+)">', path.read_text(encoding="utf-8"), re.M))
            for path in DOCS.rglob("*.md")
        }
        self.staged = {path.resolve(): path.relative_to(DOCS) for path in DOCS.rglob("*.md")
                       if path.parts[-2] not in ("paper", "site")}
        self.staged[DOCS / "site" / "index.md"] = Path("index.md")
        self.staged.update({DOCS / "site" / name: Path(name) for name in GENERATED})
        for name, source in PROJECT.items():
            if (ROOT / source).exists():
                self.staged[(ROOT / source).resolve()] = Path(name)
        self.copied: set[Path] = set()
        self.written: set[Path] = set()

    # ---- texts
    @staticmethod
    def has_equations(source: Path) -> bool:
        return source.name in WITH_EQUATIONS or source.parent.name == "theory"

    def label(self, path: Path, anchor: str) -> str:
        return f"{path.stem}-{anchor}"

    def link(self, source: Path, target: str, here: Path) -> str:
        """Where a link of a text leads on the site."""
        if re.match(r"[a-z]+:", target):
            return target
        name, _, anchor = target.partition("#")
        path = (source.parent / name).resolve() if name else source.resolve()
        if anchor and anchor in self.anchors.get(path, ()):
            return self.label(path, anchor)
        if path.suffix in (".svg", ".png"):
            return os.path.relpath(path.relative_to(DOCS), here.parent)
        if path in self.staged:
            if not name:
                return target
            return os.path.relpath(self.staged[path], here.parent) + ("#" + anchor if anchor else "")
        if path == ROOT / "README.md":
            return os.path.relpath("index.md", here.parent)
        if path.is_dir() and path.is_relative_to(ROOT / "examples"):
            return os.path.relpath("gallery.md", here.parent)
        if not path.exists():
            raise SystemExit(f"{source.relative_to(ROOT)}: a link leads nowhere: {target}")
        relative = path.relative_to(ROOT)
        if path.is_file():
            self.copied.add(relative)
            return "FILES/" + str(relative)
        for item in sorted(path.iterdir()):
            if item.is_file() and item.suffix in (".py", ".scene", ".c", ".h", ".sh", ".ini"):
                self.copied.add(item.relative_to(ROOT))
        return f"FILES/{relative}/index.html"

    def text(self, source: Path, here: Path) -> str:
        """A text as a page. Lines keep their numbers, as far as equations allow."""
        lines = source.read_text(encoding="utf-8").splitlines()
        if lines[0].startswith("## "): # a part of a report
            lines[0] = lines[0][1:]
        out: list[str] = []
        fenced, k = False, 0
        while k < len(lines):
            line = lines[k]
            if line.startswith("```"):
                fenced = not fenced
            block = not fenced and line.startswith("    ") and (not out or not out[-1].strip()) and not self.listed(out)
            if block:
                end = k
                while end < len(lines) and (lines[end] or "\n".join(lines[end + 1 : end + 2])).startswith("    "):
                    end += 1
                out += self.block(source, lines[k:end])
                k = end
                continue
            if not fenced:
                line = re.sub(r"<!--.*?-->", "", line)
                line = re.sub(r'^<a id="([^"]+)"></a>$', lambda m: f"({self.label(source, m.group(1))})=", line)
                parts = re.split(r"(`[^`]*`)", line)
                if self.has_equations(source):
                    parts = [self.formula(p) if n % 2 else p for n, p in enumerate(parts)]
                line = "".join(parts)
                line = re.sub(r"\]\(([^()\s]+)\)", lambda m: f"]({self.link(source, m.group(1), here)})", line)
            out.append(line)
            k += 1
        return self.files("\n".join(out) + "\n", here)

    @staticmethod
    def listed(out: list[str]) -> bool:
        """The last line with words belongs to a list, and so does what is indented below it."""
        last = next((line for line in reversed(out) if line.strip()), "")
        return bool(re.match(r"(\d+\.|[-*]) |  ", last))

    @staticmethod
    def files(text: str, here: Path) -> str:
        """Copies of files lie beside the pages: raw links, since they are no pages."""
        up = "../" * (len(here.parts) - 1)
        return re.sub(r"\[((?:[^\[\]]|\[[^\]]*\])*)\]\(FILES/([^)]+)\)",
                      lambda m: f'<a href="{up}files/{m.group(2)}">{html(m.group(1))}</a>', text)

    @staticmethod
    def formula(code: str) -> str:
        found = equations.inline(code[1:-1])
        return code if found is None else "{math}`" + found + "`"

    @staticmethod
    def block(source: Path, lines: list[str]) -> list[str]:
        text = [line.strip() for line in lines if line.strip()]
        command = any(re.match(r"(build/|make |cc |pd\dd |result |\[|python)", line) for line in text)
        if Site.has_equations(source) and not command:
            try:
                return ["```{math}", *equations.display(text).splitlines(), "```"]
            except equations.Unknown:
                pass
        width = min(len(line) - len(line.lstrip()) for line in lines if line.strip())
        return ["```text", *(line[width:] for line in lines), "```"]

    # ---- pages that come from the sources
    def gallery(self) -> str:
        lines = ["# Gallery", "",
                 "Scenes and programs of `examples/`, with the command that runs each. Pictures are those that a run",
                 "writes; `sh tools/gallery.sh` draws them again. `pd1d`, `pd2d` and `pd3d` are in `build/` after `make`.", ""]
        lines += ["## Scenes", ""]
        listed = set()
        programs = False
        for row in (DOCS / "site" / "gallery.txt").read_text(encoding="utf-8").splitlines():
            if row.startswith("#") or not row.strip():
                continue
            name, picture, field, *more = [part.strip() for part in row.split(";")]
            if "/tutorials/" in picture:
                continue
            scene = ROOT / "examples" / "scenes" / f"{name}.scene"
            source = scene if scene.exists() else ROOT / "examples" / f"{name}.c"
            listed.add(source)
            self.copied.add(source.relative_to(ROOT))
            if source.suffix == ".c" and not programs:
                programs = True
                lines += ["## C programs", ""]
            title, about, command = self.about(source)
            lines += [f"### {reference.escape(title)}", ""]
            if picture != "-":
                lines += [f"![{reference.escape(title)}]({picture})", ""]
            lines += [reference.escape(about), "", "```text", command + (" " + more[0] if more else ""), "```", "",
                      f"[{source.relative_to(ROOT)}](FILES/{source.relative_to(ROOT)})", ""]
        for source in [*(ROOT / "examples" / "scenes").glob("*.scene"), *(ROOT / "examples").glob("*.c")]:
            if source not in listed:
                raise SystemExit(f"docs/site/gallery.txt has no row for {source.relative_to(ROOT)}")
        return self.files("\n".join(lines), Path("gallery.md"))

    @staticmethod
    def about(source: Path) -> tuple[str, str, str]:
        """Title, first paragraph and command of a scene or a program, from its comment."""
        text = source.read_text(encoding="utf-8")
        relative = source.relative_to(ROOT)
        if source.suffix == ".c":
            comment = re.match(r"/\*(.*?)\*/", text, re.S).group(1)
            comment = re.sub(r"\n \*", "\n", comment)
            command = re.search(r"\bcc -std[^\n]*", comment)
            comment = comment.replace(command.group(), "")
            dim = ""
        else:
            comment = re.match(r"(#[^\n]*\n)+", text).group()
            comment = re.sub(r"^#", "", comment, flags=re.M)
            kind = source.stem.rsplit("_", 1)[-1]
            dim = kind if re.fullmatch(r"[123]d", kind) else "2d"
        paragraphs = [" ".join(p.split()) for p in re.split(r"\n\s*\n", comment.strip())]
        title, _, rest = paragraphs[0].partition(". ")
        title = re.sub(r"^\d\d: ", "", title).rstrip(".: ")
        about = rest or (paragraphs[1] if len(paragraphs) > 1 else "")
        if len(title) > 90 and ": " in title:
            title, rest = title.split(": ", 1)
            about = rest[0].upper() + rest[1:] + ". " + about
        return title, about, command.group().strip() if source.suffix == ".c" else f"pd{dim} {relative}"

    def contents(self) -> str:
        lines = []
        for caption, pages in CONTENTS:
            lines += ["", "```{toctree}", ":hidden:", f":caption: {caption}", "", *pages, "```"]
        return "\n".join(lines) + "\n"

    @staticmethod
    def chapters(source: Path) -> str:
        """The chapters of the theory in the order of its table."""
        names = re.findall(r"^\| \d+ \|.*?\]\((theory/\w+)\.md\)", source.read_text(encoding="utf-8"), re.M)
        return "\n".join(["", "```{toctree}", ":hidden:", "", *names, "```"]) + "\n"

    # ---- all of it
    def write(self, name: str, text: str) -> None:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text: # Sphinx reads what has changed
            path.write_text(text, encoding="utf-8")
        self.written.add(path)

    def stage(self, katex: Path) -> None:
        for folder in ("img", "_static", "_files"):
            shutil.rmtree(self.folder / folder, ignore_errors=True)
        for source, here in self.staged.items():
            if here.name in GENERATED:
                continue
            text = self.text(source, here)
            if here.name == "index.md":
                text += self.contents()
            if here.name == "theory.md":
                text += self.chapters(source)
            self.write(str(here), text)
        header = reference.Header()
        self.write("keys.md", reference.keys(self.build / "pd2d"))
        self.write("api.md", header.index() + "\n```{toctree}\n:hidden:\n\n" + "\n".join(
            f"api/{room}" for room in header.rooms if header.modules[room]) + "\n```\n")
        for room in header.rooms:
            if header.modules[room]:
                self.write(f"api/{room}.md", header.page(room))
        self.write("gallery.md", self.gallery())
        for old in set(self.folder.rglob("*.md")) - self.written:
            old.unlink()
        shutil.copytree(DOCS / "img", self.folder / "img")
        static = self.folder / "_static"
        (static / "katex" / "fonts").mkdir(parents=True)
        for name in ("katex.min.css", "katex.min.js"):
            shutil.copy(katex / name, static / "katex" / name)
        for font in (katex / "fonts").glob("*.woff2"):
            shutil.copy(font, static / "katex" / "fonts" / font.name)
        for name in ("site.css", "math.js"):
            shutil.copy(DOCS / "site" / name, static / name)
        files = self.folder / "_files" / "files"
        for relative in sorted(self.copied):
            (files / relative).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / relative, files / relative)
        for folder in {path.parent for path in self.copied}:
            names = sorted(path.name for path in self.copied if path.parent == folder)
            links = "".join(f'<li><a href="{name}">{name}</a></li>' for name in names)
            (files / folder / "index.html").write_text(
                f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{folder}</title><h1>{folder}</h1>'
                f"<ul>{links}</ul></html>\n", encoding="utf-8")


def html(text: str) -> str:
    text = text.replace("&", "&amp;").replace("<", "&lt;")
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", text)


def main() -> None:
    parser = argparse.ArgumentParser(description="Stages the pages of the site.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--build", type=Path, default=ROOT / "build")
    parser.add_argument("--katex", type=Path, default=Path("/usr/share/javascript/katex"))
    arguments = parser.parse_args()
    Site(arguments.folder, arguments.build.resolve()).stage(arguments.katex)


if __name__ == "__main__":
    main()
