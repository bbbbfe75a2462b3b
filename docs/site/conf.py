"""Sphinx configuration of the site. `make site` stages the pages (stage.py) and runs Sphinx on them."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
header = Path(__file__).resolve().parent.parent.parent / "pdcorr.h"

project = "pdcorr"
author = "the pdcorr authors"
copyright = "2026, the pdcorr authors"  # pylint: disable=redefined-builtin
release = version = re.search(r"pdcorr (\d+\.\d+\.\d+)", header.read_text(encoding="utf-8")[:200]).group(1)
extensions = ["myst_parser"]
myst_heading_anchors = 4
nitpicky = True
smartquotes = False
highlight_language = "none"
html_theme = "furo"
html_title = f"pdcorr {release}"
html_css_files = ["katex/katex.min.css", "site.css"]
html_js_files = ["katex/katex.min.js", "math.js"]
html_math_renderer = "katex"
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
html_last_updated_fmt = None


def visit_math(self, node):
    """Formulas as text between marks, which math.js hands to KaTeX."""
    self.body.append(self.starttag(node, "span", "", CLASS="math"))
    self.body.append(self.encode(node.astext()) + "</span>")
    raise_skip()


def visit_math_block(self, node):
    self.body.append(self.starttag(node, "div", CLASS="math"))
    self.body.append(self.encode(node.astext()) + "</div>\n")
    raise_skip()


def raise_skip():
    from docutils import nodes  # pylint: disable=import-outside-toplevel
    raise nodes.SkipNode


def setup(app):
    app.config.html_static_path = [str(Path(app.srcdir) / "_static")]
    app.config.html_extra_path = [str(Path(app.srcdir) / "_files")]
    app.add_html_math_renderer("katex", inline_renderers=(visit_math, None), block_renderers=(visit_math_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
