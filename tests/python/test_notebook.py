# SPDX-License-Identifier: Apache-2.0
"""Executes the cells of examples/python/reaming.ipynb in order, without Jupyter."""
import contextlib
import io
import json
import os
import sys
import types

import osteon


def test_every_cell_runs(tmp_path, monkeypatch):
    name = os.path.join(os.environ["OSTEON_SOURCE"], "examples", "python", "reaming.ipynb")
    with open(name, encoding="utf-8") as file:
        notebook = json.load(file)
    assert notebook["nbformat"] == 4
    assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in notebook["cells"])
    pictures = []
    display = types.ModuleType("IPython.display")
    display.Image = lambda filename: pictures.append(filename)
    monkeypatch.setitem(sys.modules, "IPython", types.ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.chdir(tmp_path)
    scope, printed = {}, io.StringIO()
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    with contextlib.redirect_stdout(printed):
        for number, cell in enumerate(cells):
            exec(compile(cell, f"cell {number}", "exec"), scope)  # pylint: disable=exec-used
    assert len(cells) >= 8 and all(os.path.getsize(picture) > 1000 for picture in pictures) and len(pictures) == 2
    # the results that the text of the notebook states
    assert scope["left"] and scope["missed"].by_kind["removed"] > 0
    assert scope["result"].findings[0].margin == 2 and isinstance(scope["result"], osteon.CheckResult)
    assert "equal=True" in printed.getvalue()
