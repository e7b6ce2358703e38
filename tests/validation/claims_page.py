# SPDX-License-Identifier: Apache-2.0
"""The page report.html of a bundle, parsed for check_claims.py: sentences, rows and pictures in sections, with their
links."""
import html.parser

BLOCKS = {"title", "h1", "h2", "h3", "p", "li", "tr", "pre", "figure", "figcaption", "label", "div", "span"}
VOID = {"br", "img", "input", "meta", "path", "link"}


class WrongClaim(Exception):
    """A claim of the page that does not follow from the files to which it links."""


class Block:
    """A sentence or a row, with the links that it contains."""

    def __init__(self, tag, attributes):
        self.tag, self.attributes = tag, attributes
        self.text, self.links, self.bold, self.cells, self.used = "", [], "", [], False

    def clean(self):
        self.text = " ".join(self.text.split())
        self.bold = " ".join(self.bold.split())
        self.cells = [" ".join(c.split()) for c in self.cells]

    def __str__(self):
        return "<%s> %s" % (self.tag, " | ".join(self.cells) or self.text)


class Page(html.parser.HTMLParser):
    """Collects the blocks of the page in their order. A text belongs to its innermost block."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.blocks, self.open, self.tags, self.ids, self.skip = [], [], [], set(), 0
        self.feed(text)
        if self.tags:
            raise WrongClaim("report.html: <%s> is not closed" % self.tags[-1])
        for block in self.blocks:
            block.clean()

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if "id" in attributes:
            self.ids.add(attributes["id"])
        if tag == "style":
            self.skip += 1
        if tag in BLOCKS and not (tag == "title" and self.open) and not (tag == "span" and self.open and self.open[-1].tag in ("figcaption", "div", "p")):
            self.open.append(Block(tag, attributes))
            self.blocks.append(self.open[-1])
        elif tag == "a":
            self.open[-1].links.append(attributes["href"])
        elif tag in ("td", "th"):
            self.open[-1].cells.append("")
        elif tag in ("br", "title"):
            self.handle_data(" ")
        elif tag in ("b", "strong") and self.open:
            self.open[-1].bold += " "
        elif tag == "img":
            self.open[-1].links.append(attributes["src"])
            self.open[-1].text += attributes["alt"]
        if tag not in VOID:
            self.tags.append(tag)

    def handle_endtag(self, tag):
        if tag in VOID:
            return
        if not self.tags or self.tags[-1] != tag:
            raise WrongClaim("report.html: </%s> closes the element %s" % (tag, self.tags[-1:]))
        self.tags.pop()
        if tag == "style":
            self.skip -= 1
        if self.open and self.open[-1].tag == tag and not (tag == "span" and self.open[-1].tag != "span"):
            self.open.pop()

    def handle_data(self, data):
        if self.skip or not self.open:
            return
        block = self.open[-1]
        block.text += data
        if block.cells:
            block.cells[-1] += data
        if any(t in ("b", "strong") for t in self.tags):
            block.bold += data


class Section:
    def __init__(self, name):
        self.name, self.blocks, self.sources = name, [], []


def sections_of(page):
    """Splits the page at its headings. The sources of a section are the links in its lines 'From ...'."""
    sections = [Section("")]
    for block in page.blocks:
        if block.tag == "h2":
            sections.append(Section(block.text))
            block.used = True
        sections[-1].blocks.append(block)
        if block.tag == "p" and block.attributes.get("class") == "from":
            sections[-1].sources += block.links
    return sections
