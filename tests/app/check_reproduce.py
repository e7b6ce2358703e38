#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the files of osteon reproduce in folders: CSV against JSON, SVG and HTML as XML.

Usage: check_reproduce.py DIR..."""
import csv
import html.parser
import json
import os
import sys
import xml.etree.ElementTree

problems = []


def expect(condition, text):
    if not condition:
        problems.append(text)


def cell(value, column):
    """Returns the CSV fields of a cell in JSON: the value and, if the column has values of the thesis, that value."""
    if column["text"]:
        return [value]
    if not column["thesis"]:
        return [value]
    return [value["value"], value["thesis"]]


def check_item(folder, name):
    with open(os.path.join(folder, name), encoding="utf-8") as f:
        item = json.load(f)
    expect(item["format"] == "osteon-reproduction-1", f"{name}: unexpected format {item['format']}")
    expect(item["item"] + ".json" == name, f"{name}: the file contains the item {item['item']}")
    for picture in item["pictures"]:
        expect(os.path.isfile(os.path.join(folder, picture["file"])), f"{name}: the picture {picture['file']} does not exist")
    keys = {c["key"] for c in item["columns"]}
    for plot in item["plots"]:
        for key in [plot["x"], *plot["values"], *([plot["group"]] if plot["group"] else [])]:
            expect(key in keys, f"{name}: a plot refers to {key}, which is not a column")
    for finding in item["findings"]:
        expect(finding["reason"] and finding["claim"] and finding["source"], f"{name}: a finding has an empty text")
        expect("nan" not in finding["reason"] and "inf" not in finding["reason"], f"{name}: the reason of a finding contains an invalid number: {finding['reason']}")
    if not item["rows"]:
        return
    with open(os.path.join(folder, name[:-5] + ".csv"), encoding="utf-8", newline="") as f:
        rows = list(csv.reader(f))
    head = ["machine"]
    for c in item["columns"]:
        head += [c["key"]] + ([c["key"] + "_thesis"] if c["thesis"] else [])
    expect(rows[0] == head, f"{name}: columns {rows[0]} in CSV, {head} in JSON")
    expect(len(rows) == len(item["rows"]) + 1, f"{name}: {len(rows) - 1} rows of CSV, {len(item['rows'])} of JSON")
    for line, row in zip(rows[1:], item["rows"]):
        expect(line[0] == item["machines"][row["machine"]]["label"], f"{name}: the machine {line[0]} in CSV differs from JSON")
        values = [v for c in item["columns"] for v in cell(row[c["key"]], c)]
        for text, value in zip(line[1:], values):
            if isinstance(value, float):
                expect(float(text) == value, f"{name}: {text} in CSV, {value} in JSON")
            else:
                expect(text == (value or ""), f"{name}: '{text}' in CSV, '{value}' in JSON")


class Page(html.parser.HTMLParser):
    """Counts open elements."""

    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img", "br", "path", "rect", "circle"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        if tag in ("path", "rect", "circle"):
            return
        expect(self.open and self.open.pop() == tag, f"report: </{tag}> closes no open element")


for folder in sys.argv[1:]:
    names = sorted(os.listdir(folder))
    for name in names:
        if name.endswith(".json"):
            check_item(folder, name)
        if name.endswith(".svg"):
            try:
                root = xml.etree.ElementTree.parse(os.path.join(folder, name)).getroot()
                expect(root.tag.endswith("svg"), f"{name}: is not SVG")
            except xml.etree.ElementTree.ParseError as e:
                problems.append(f"{folder}/{name}: {e}")
    page = Page()
    with open(os.path.join(folder, "report.html"), encoding="utf-8") as f:
        page.feed(f.read())
    expect(not page.open, f"{folder}/report.html: elements that are not closed: {page.open}")
for problem in problems[:20]:
    print(problem)
sys.exit(1 if problems else 0)
