"""Equations of laws, which are plain text, as MathML, which browsers typeset by themselves.

``p/d = 2.28 (rho_p/rho_t)^(2/3)``: letters are quantities and may have a subscript, Greek ones are written by name,
``^`` raises, and brackets of [] and {} behind a slash are a denominator. Units and other words stand between formulas,
which so break into lines.
"""

import re
from collections.abc import Iterator
from itertools import groupby, takewhile

from markupsafe import Markup, escape

GREEK = {"rho": "ρ", "theta": "θ", "delta": "δ", "epsilon": "ε"}
SIGNS = {"-": "−", "<=": "≤", ">=": "≥", "x": "×"}
CLOSING = {"(": ")", "[": "]", "{": "}"}
TOKEN = re.compile(
    r"(?P<function>sqrt|ln|exp|cos)(?=[(\[])"
    r"|(?P<times>(?<=\d )x(?= \d))"
    rf"|(?P<letter>(?:{'|'.join(GREEK)}|[A-Za-z])(?:_[A-Za-z0-9]+)?(?![A-Za-z0-9])(?<!\ba)(?<!\bg)(?<!\bJ))"
    r"|(?P<number>\d+(?:\.\d+)?(?![\w-]*-[A-Z]))"
    r"|(?P<sign><=|>=|[-+=<>](?![A-Z]))"
    r"|(?P<over>/)|(?P<power>\^)|(?P<index>_\w+)|(?P<bracket>[][(){}])|(?P<space> +)"
    r"|(?P<words>(?:[kcm]?m[23]?|g|J)/(?:cm3|s|J)|[\w-]+|.)"
)


def formula(equation: str) -> Markup:
    """An equation as HTML with MathML.

    >>> print(formula("D = 2 p, p by all"))
    <math><mi>D</mi></math> <math><mo form="infix">=</mo><mn>2</mn><mi>p</mi></math>, <math><mi>p</mi></math> by all
    >>> print(formula("D = 2^"))
    D = 2^
    """
    tokens = [(match.lastgroup or "", match[0]) for match in TOKEN.finditer(equation)]
    try:
        return Markup("").join(_Equation(tokens).pieces())
    except IndexError:  # it ends before its bracket, its power or its denominator
        return escape(equation)


LONGEST = 2  # nodes of a formula that a further group would make too wide for a telephone


class _Equation:
    """The tokens of an equation, from first to last."""

    def __init__(self, tokens: list[tuple[str, str]]):
        self.tokens = tokens
        self.place = 0

    def pieces(self) -> Iterator[Markup]:
        """Formulas, each up to a sign between its terms, and the words between them."""
        for is_words, group in groupby(self._nodes(None), key=lambda node: isinstance(node, _Words)):
            nodes = list(group)
            if is_words:
                yield Markup("").join(escape(node) for node in nodes)
                continue
            terms: list[list[str]] = [[]]
            for node in nodes:
                is_sign, is_group = node.startswith("<mo>"), node.startswith(("<msup", "<mrow", "<mfrac"))
                if terms[-1] and (is_sign or (is_group and len(terms[-1]) >= LONGEST)):
                    terms.append([])
                terms[-1].append(node.replace("<mo>", '<mo form="infix">') if node.startswith("<mo>") else node)
            yield Markup(" ").join(Markup(f"<math>{''.join(term)}</math>") for term in terms)

    def _nodes(self, closing: str | None) -> list[str]:
        """The nodes up to a closing bracket, or to the end."""
        nodes: list[str] = []
        while self.place < len(self.tokens):
            kind, text = self.tokens[self.place]
            if text == closing:
                break
            if closing is None and text == "(" and self._has_words():
                self.place += 1
                nodes.append(_Words(text))
                continue
            if kind == "number" and nodes and nodes[-1].endswith("</mn>"):
                nodes.append("<mo>·</mo>")
            if kind == "over" and nodes and not isinstance(nodes[-1], _Words):
                self.place += 1
                nodes = self._divided(nodes)
            elif kind == "space":
                self.place += 1
                if closing is None and (not nodes or isinstance(nodes[-1], _Words) or self._next_is_words()):
                    nodes.append(_Words(text))
            else:
                nodes.append(self._raised())
        return nodes

    def _has_words(self) -> bool:
        """Whether words stand in the brackets that open here."""
        inside = (kind for kind, text in takewhile(lambda token: token[1] != ")", self.tokens[self.place :]))
        return "words" in inside

    def _next_is_words(self) -> bool:
        return self.place < len(self.tokens) and self.tokens[self.place][0] == "words"

    def _divided(self, nodes: list[str]) -> list[str]:
        """The nodes with what follows a slash: under the term before it, where it stands in its own brackets."""
        while self.tokens[self.place][0] == "space":
            self.place += 1
        is_group = self.tokens[self.place][1] in ("[", "{")
        below = self._raised(bare=is_group)
        if not is_group:
            return [*nodes, "<mi>/</mi>", below]
        signs = [place for place, node in enumerate(nodes) if node.startswith("<mo>") or isinstance(node, _Words)]
        begin = signs[-1] + 1 if signs else 0
        above = nodes[begin:]
        if len(above) == 1:
            above = [_bare(above[0])]
        return [*nodes[:begin], f"<mfrac><mrow>{''.join(above)}</mrow>{below}</mfrac>"]

    def _raised(self, *, bare: bool = False) -> str:
        """A node with its power or its index; ``bare``: a group without either loses its brackets."""
        node = self._node()
        while self.place < len(self.tokens) and self.tokens[self.place][0] in ("power", "index"):
            kind, text = self.tokens[self.place]
            self.place += 1
            if kind == "index":
                node, bare = f"<msub>{node}<mtext>{text[1:]}</mtext></msub>", False
                continue
            minus = "<mo>−</mo>" if self.tokens[self.place][1] == "-" else ""
            self.place += bool(minus)
            node, bare = f"<msup>{node}<mrow>{minus}{_bare(self._node())}</mrow></msup>", False
        return _bare(node) if bare else node

    def _node(self) -> str:
        kind, text = self.tokens[self.place]
        self.place += 1
        if kind == "letter":
            name, _, index = text.partition("_")
            letter = f"<mi>{GREEK.get(name, name)}</mi>"
            return f"<msub>{letter}<mi>{GREEK.get(index, index)}</mi></msub>" if index else letter
        if kind == "function":
            group = self._node()
            return f"<msqrt>{_bare(group)}</msqrt>" if text == "sqrt" else f"<mrow><mi>{text}</mi>{group}</mrow>"
        if kind == "bracket" and text in CLOSING:
            inside = "".join(
                f"<mtext>{escape(n)}</mtext>" if isinstance(n, _Words) else n for n in self._nodes(CLOSING[text])
            )
            self.place += 1
            high = str("<mfrac" in inside).lower()
            left, right = (f'<mo stretchy="{high}">{bracket}</mo>' for bracket in (text, CLOSING[text]))
            return f"<mrow>{left}{inside}{right}</mrow>"
        if kind in ("sign", "times"):
            return f"<mo>{escape(SIGNS.get(text, text))}</mo>"
        return f"<mn>{text}</mn>" if kind == "number" else _Words(text)


def _bare(node: str) -> str:
    """A group without its brackets."""
    return re.sub(r'^<mrow><mo stretchy="\w+">.</mo>(.*)<mo stretchy="\w+">.</mo></mrow>$', r"<mrow>\1</mrow>", node)


class _Words(str):
    """Text between formulas."""
