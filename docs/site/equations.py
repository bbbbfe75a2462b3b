"""Equations of the texts, which are plain text that can be read anywhere, as LaTeX for the site.

    u_i = G1 delta (1 - delta M/2) + Lambda delta^2/2.                                          (2.7)

Greek names, `sum_open`, `sqrt(..)`, fractions `a/b` without spaces, `|x|`, `x.y` for a dot product and words are known.
Three spaces or more separate equations of a line; its number stands at the end.
"""
import re

GREEK = set("""alpha beta gamma delta epsilon eta theta kappa lambda mu nu xi pi rho sigma tau phi psi omega Lambda
    Omega Delta Gamma""".split())
FUNCTIONS = set("exp max min sin cos tan sinh cosh tanh ln log det".split())
OPERATORS = {name: rf"\operatorname{{{name}}}" for name in "asin acos atan erf tr dev lap div log10".split()}
WORDS_OF_TWO = set("of in is or at so if to by no on as".split())
PLAIN_WORDS = set("and the from that with its two one all for over node place means max where".split())
RELATIONS = [("<=", r"\le "), (">=", r"\ge "), ("!=", r"\ne "), ("->", r"\to "), ("<-", r"\leftarrow "),
             ("+-", r"\pm "), ("...", r"\dots "), ("..", r"\dots ")]
NUMBER = re.compile(r"\d+(\.\d+)?(e-?\d+)?")
NAME = re.compile(r"[A-Za-z]+")
WIDTH = 66 # characters of a row
TAG = re.compile(r"\s\((\d+(?:\.\d+[a-z]*)?(?:, [a-z]+)?)\)\s*$")


class Unknown(ValueError):
    """The notation does not reach that far."""


def word(name: str) -> str:
    return rf"\text{{{name}}}"


def symbol(name: str) -> str:
    """LaTeX of an identifier without subscripts."""
    if name in GREEK:
        return "\\" + name
    if name == "grad":
        return r"\nabla "
    if name in FUNCTIONS:
        return "\\" + name
    if name in OPERATORS:
        return OPERATORS[name]
    if len(name) == 1:
        return name
    if re.fullmatch("[A-Z]hat", name):
        return rf"\hat{{{name[0]}}}"
    if name[0] == "d" and (name[1:] in GREEK or len(name) == 2):
        return rf"\mathrm{{d}}{symbol(name[1:])}"
    if name[0] == "C" and name[1:] in ("s", "sat", "end"):
        return rf"C_\mathrm{{{name[1:]}}}"
    if len(name) == 2 and name not in WORDS_OF_TWO:
        return rf"\mathit{{{name}}}"
    return word(name)


class Reader:
    """A line of plain notation, read from left to right. small: for a line of words, where a/b stays as it is."""

    def __init__(self, text: str, small: bool = False):
        self.text, self.at, self.small = text, 0, small

    def peek(self, count: int = 1) -> str:
        return self.text[self.at : self.at + count]

    def before(self) -> str:
        return self.text[self.at - 1] if self.at else " "

    def sequence(self, end: str) -> str:
        """Up to the closing character, which is passed."""
        out: list[str] = []
        while True:
            if self.at >= len(self.text):
                if end:
                    raise Unknown(f"no '{end}' in '{self.text}'")
                return "".join(out)
            char = self.peek()
            if end and char == end:
                self.at += 1
                return "".join(out)
            if char == " ":
                run = len(self.text[self.at :]) - len(self.text[self.at :].lstrip(" "))
                self.at += run
                out.append(r"\quad " if run > 1 else self.gap())
                continue
            relation = next((r for r in RELATIONS if self.text.startswith(r[0], self.at)), None)
            if relation:
                self.at += len(relation[0])
                out.append(relation[1])
                continue
            if char in "=+-,;:!*/<>":
                bracket = char == "<" and self.text[self.at + 1 : self.at + 2].strip() and ">" in self.text[self.at :]
                if not bracket:
                    self.at += 1
                    out.append({"*": r"\cdot "}.get(char, char + (" " if char in "<>" else "")))
                    continue
            if char == ".":
                dot = self.before().strip() and self.text[self.at + 1 : self.at + 2].strip(" ,)")
                alone = self.before() == "(" or (not self.before().strip())
                self.at += 1
                out.append(r"\cdot " if dot or alone else ".")
                continue
            if char in ")]}":
                raise Unknown(f"'{char}' in '{self.text}'")
            self.fraction(*self.atom(), out)

    def gap(self) -> str:
        """A space between two atoms: a thin one in a product, a word space beside words; none beside operators."""
        text = self.text[: self.at].rstrip()
        if not text or text[-1] in "=+-<>,;([/*" or self.peek() in "=+-<>,;)]/*":
            return " "
        left = re.search(r"[A-Za-z]{2,}$", text)
        for match in (left, NAME.match(self.text, self.at)):
            name = match.group() if match else ""
            if name and name not in ("sum", "int", "sqrt") and symbol(name).startswith(r"\text"):
                return r"\ "
        return r"\," if self.peek().isalnum() else " "

    def fraction(self, latex: str, bare: str, out: list[str]) -> None:
        """Appends a/b of neighbours, with the factors before a, or the atom alone. bare: without brackets around it."""
        while self.peek() == "/" and self.text[self.at + 1 : self.at + 2].strip(" /"):
            self.at += 1
            if self.small:
                latex += "/" + self.atom()[0]
                continue
            factors = ""
            while out and (out[-1] in (" ", r"\,", r"\cdot ") or self.factor(out[-1])):
                factors = out.pop() + factors
            above = factors.lstrip(" ") + latex if factors.strip(" ") else bare
            if factors.startswith(" "):
                out.append(" ")
            _, below = self.atom()
            latex = bare = rf"\frac{{{above}}}{{{below}}}"
        out.append(latex)

    @staticmethod
    def factor(latex: str) -> bool:
        """May stand above a fraction line with what follows it."""
        return not re.match(r"\\(sum|int|text|frac|min|max|exp|operator|nabla|le|ge|ne|to|left|pm|dots|quad| )"
                            r"|[=+\-,;:!/<>.]", latex)

    def atom(self) -> tuple[str, str]:
        char = self.peek()
        pairs = {"(": ")", "[": "]", "{": "}", "|": "|", "<": ">"}
        if char in pairs:
            self.at += 1
            inner = self.sequence(pairs[char])
            left, right = {"|": (r"\lvert ", r"\rvert "), "<": (r"\langle ", r"\rangle "), "{": (r"\{", r"\}")}.get(
                char, (char, pairs[char]))
            latex = bare = rf"{left}{inner}{right}"
            if char == "(":
                bare = inner
            marks = self.marks()
            return latex + marks, latex + marks if marks else bare
        number = NUMBER.match(self.text, self.at)
        if number:
            self.at = number.end()
            digits = number.group()
            if "e" in digits:
                mantissa, power = digits.split("e")
                digits = (rf"{mantissa}\cdot " if mantissa != "1" else "") + rf"10^{{{power}}}"
            if NAME.match(self.text, self.at) and self.text[self.at :].startswith("D"):
                self.at += 1
                digits += r"\mathrm{D}"
            digits += self.marks()
            return digits, digits
        name = NAME.match(self.text, self.at)
        if not name:
            raise Unknown(f"'{char}' in '{self.text}'")
        self.at = name.end()
        return self.named(name.group())

    def named(self, name: str) -> tuple[str, str]:
        if name == "sqrt" and self.peek() == "(":
            self.at += 1
            root = rf"\sqrt{{{self.sequence(')')}}}" + self.marks()
            return root, root
        if name in ("sum", "int"):
            limits = name == "sum" and self.peek() == "_" and not self.small
            latex = "\\" + name + (r"\limits" if limits else "") + self.marks()
            return latex + " ", latex + " "
        latex = symbol(name)
        digit = re.match(r"\d", self.text[self.at :])
        if digit and (len(name) == 1 or name in GREEK):
            self.at += 1
            latex += rf"_{{{digit.group()}}}" if self.peek() != "_" else digit.group()
        marks = self.marks()
        if "_" in latex and "_" in marks: # Cs_m
            latex = rf"{{{latex}}}"
        latex = rf"\tilde{{{latex}}}{marks[1:]}" if marks.startswith("~") else latex + marks
        if self.peek() in ("(", "[") and name not in WORDS_OF_TWO and not latex.startswith(r"\text{and"):
            opening = self.peek()
            self.at += 1
            closing = {"(": ")", "[": "]"}[opening]
            latex += opening + self.sequence(closing) + closing + self.marks()
        elif latex.startswith("\\") and latex[-1].isalpha():
            latex += " "
        return latex, latex

    def marks(self) -> str:
        """Subscripts, powers, primes and signs right behind an atom."""
        below, above, tilde = [], "", ""
        while True:
            char = self.peek()
            rest = self.text[self.at + 1 : self.at + 2]
            if char == "_" and rest.strip():
                self.at += 1
                below.append(self.script())
            elif char == "^" and rest.strip():
                self.at += 1
                above += self.power()
            elif char == "'":
                self.at += 1
                above += r"\prime "
            elif char == "~":
                self.at += 1
                tilde = "~"
            elif char in "+-*" and (not rest or rest in " ,;.)]}(_") and self.before().strip() and char:
                if self.text[self.at - 1] in ")]}" or self.text[self.at : self.at + 2] in ("..",):
                    break
                self.at += 1
                above += char
            else:
                break
        return tilde + (rf"_{{{','.join(below)}}}" if below else "") + (rf"^{{{above}}}" if above else "")

    def script(self) -> str:
        if self.peek() == "(":
            self.at += 1
            return self.sequence(")")
        match = re.compile(r"[A-Za-z0-9]+(,[a-z])?|[+-]").match(self.text, self.at)
        if not match:
            raise Unknown(f"subscript in '{self.text}'")
        self.at = match.end()
        name = match.group()
        if name in GREEK:
            return "\\" + name
        return name if len(name.replace(",", "")) <= 2 or re.fullmatch(r"[ijkab]{1,3}", name) else rf"\mathrm{{{name}}}"

    def power(self) -> str:
        if self.peek() == "(":
            self.at += 1
            return self.sequence(")")
        match = re.compile(r"-?\d+|-?[A-Za-z]+").match(self.text, self.at)
        if not match:
            raise Unknown(f"power in '{self.text}'")
        self.at = match.end()
        power = match.group()
        if power in ("T", "-T"):
            return power.replace("T", r"\mathsf{T}")
        return ("\\" if power in GREEK else "") + power


def sentence(text: str) -> bool:
    """More of a sentence than of a formula."""
    return not re.search(r"=|/|sum", text) and len(re.findall(r"\b[a-z]{2,}\b", text)) > 4


def latex(text: str) -> str:
    """One formula."""
    if sentence(text):
        return r"\text{%s}" % re.sub(r"([_^#%&{}])", r"\\\1", text)
    return Reader(text).sequence("").strip()


UNIT = re.compile(r"\s+\[([a-z0-9/]+)\]")


def row(pieces: list[str]) -> str:
    out = []
    for piece in pieces:
        unit = UNIT.search(piece)
        out.append(latex(piece[: unit.start()]) + r"\quad\text{[%s]}" % unit.group(1) if unit else latex(piece))
    return "& " + r" \qquad ".join(out)


def display(lines: list[str]) -> str:
    """A block of lines as the LaTeX of a display with numbers. Raises Unknown."""
    rows = []
    for line in lines:
        found = TAG.search(line)
        tag = ""
        if found:
            tag, line = rf"\tag{{{found.group(1)}}}", line[: found.start()]
        inner = re.match(r"(.*\S)\s+\((\d+\.\d+[a-z]*)\)\s{3,}(.*)$", line)
        parts = [(inner.group(1), rf"\tag{{{inner.group(2)}}}"), (inner.group(3), tag)] if inner else [(line, tag)]
        for part, number in parts:
            groups: list[list[str]] = [[]]
            part = re.sub(r"^(and|or)\s+", r"\1 ", part.strip())
            for piece in re.sub(r"(\S)\s+(\[[a-z0-9/]+\])", r"\1 \2", part).split("   "):
                piece = piece.strip()
                if not piece:
                    continue
                width = sum(map(len, groups[-1])) + len(piece)
                if groups[-1] and re.search(r"[=<>]", piece) and groups[-1][-1] not in ("or", "and") and width > WIDTH:
                    groups.append([])
                groups[-1].append(piece)
            rows += [row(group) + (number if group is groups[-1] else "") for group in groups]
    return "\\begin{align*}\n" + " \\\\\n".join(rows) + "\n\\end{align*}"


SYMBOLS = re.compile(r"[A-Za-z0-9_^'+\-*/=<>|().,:;~!\[\] ]+")


def inline(code: str) -> str | None:
    """LaTeX of what stands between backquotes, when it is a formula; None: a name, a command, a key."""
    other = r"[a-z]{2,}_[a-z]{2,}|\.[a-z]{1,4}$|[a-z]{2,}/[a-z]|^-|--|\w x \w"
    if not SYMBOLS.fullmatch(code) or re.search(other, code):
        return None
    for name in NAME.findall(re.sub(r"_\(?[A-Za-z0-9]+", "", code)):
        if name in GREEK or name in FUNCTIONS or name in OPERATORS or len(name) == 1:
            continue
        if name in ("sum", "int", "sqrt", "grad", "Cs", "Csat", "Rc", "Ru", "Re", "dt", "dx", "dy"):
            continue
        if re.fullmatch(r"d[A-Za-z]|[A-Z]hat", name):
            continue
        return None
    try:
        return Reader(code, small=True).sequence("").strip()
    except Unknown:
        return None
