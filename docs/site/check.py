"""Checks the site that was built: links and their anchors, what must not show, nothing from a network, spelling.

    python3 docs/site/check.py PAGES STAGED

Words that no dictionary has stand in docs/site/words.txt. Says what is wrong, a line each, and ends with 1.
"""
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

HERE = Path(__file__).resolve().parent
GENERATED = ("genindex.html", "search.html") # whose parts the theme fills in


class Page(HTMLParser):
    def __init__(self, path: Path):
        super().__init__()
        self.anchors: set[str] = {""}
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.comments: list[str] = []
        self.texts: list[str] = []
        self.hidden = 0
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        for key in ("id", "name"):
            if given.get(key):
                self.anchors.add(given[key])
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        if tag in ("script", "img", "iframe", "source") and given.get("src"):
            self.loaded.append(given["src"])
        if tag == "link" and given.get("href") and given.get("rel") != "canonical":
            self.loaded.append(given["href"])
        self.hidden += tag in ("script", "style")

    def handle_endtag(self, tag):
        self.hidden -= tag in ("script", "style")

    def handle_data(self, data):
        if not self.hidden:
            self.texts.append(data)

    def handle_comment(self, data):
        self.comments.append(data)


def pages(root: Path) -> list[str]:
    """What is wrong with the pages."""
    known = {path: Page(path) for path in root.rglob("*.html")}
    wrong = []
    for path, page in known.items():
        here = path.relative_to(root)
        for target in page.links + page.loaded:
            parts = urlsplit(target)
            if parts.scheme in ("http", "https", "mailto", "data"):
                if target in page.loaded and parts.scheme != "data":
                    wrong.append(f"{here}: loads {target} from a network")
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if file.is_dir():
                file /= "index.html"
            if not file.exists():
                wrong.append(f"{here}: a link leads nowhere: {target}")
            elif parts.fragment and file in known and here.name not in GENERATED \
                    and unquote(parts.fragment) not in known[file].anchors:
                wrong.append(f"{here}: no such place: {target}")
        text = "".join(page.texts)
        for shown in re.finditer(r"<!--|FILES/|\{math\}|\]\([\w./#-]+\)", text):
            if "files" not in here.parts:
                wrong.append(f"{here}: shows markup: ...{text[max(shown.start() - 40, 0):][:90]!r}")
    return wrong


def spelling(staged: Path) -> list[str]:
    """Words of the texts that are in no dictionary, each once."""
    seen: dict[str, str] = {}
    for path in sorted(staged.rglob("*.md")):
        text = path.read_text(encoding="utf-8")
        text = re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)
        text = re.sub(r"\{math\}`[^`]*`|`[^`]*`|\]\([^)]*\)|<[^>]*>|^\([\w.-]+\)=$|https?://\S+", " ", text, flags=re.M)
        text = re.sub(r"\\(?=[\\*_\[\]<>|#$`~])", "", text)
        text = re.sub(r"\S*[_/\\=+^|\[\]{}]\S*|\S*\w\.\w\S*|\S*\d\S*", " ", text) # names, files, formulas, numbers
        for word in re.findall(r"[A-Za-z][A-Za-z']*[A-Za-z]|[^\W\d_]*[^\x00-\x7f]\w*", text):
            seen.setdefault(word.removesuffix("'s"), str(path.relative_to(staged)))
    own = {word.strip().lower() for word in (HERE / "words.txt").read_text(encoding="utf-8").splitlines()}
    asked = sorted(word for word in seen if word.lower() not in own)
    said = subprocess.run(["hunspell", "-d", "en_GB,en_US", "-l"], input="\n".join(asked), check=True,
                          capture_output=True, text=True, encoding="utf-8").stdout.split()
    return [f"{seen.get(word, '?')}: '{word}' is in no dictionary (docs/site/words.txt)" for word in said]


def main() -> int:
    wrong = pages(Path(sys.argv[1]).resolve()) + spelling(Path(sys.argv[2]).resolve())
    print("\n".join(wrong))
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
