"""The notebook of the first hour runs, from its first cell to its last."""

from __future__ import annotations

import nbformat
from conftest import ROOT
from nbclient import NotebookClient

NOTEBOOK = ROOT / "python" / "notebooks" / "first-hour.ipynb"


def test_the_first_hour_runs():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "it is kept without outputs: they are the test's"
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(NOTEBOOK.parent)}}).execute()
    shown = {cell["id"]: cell.get("outputs", []) for cell in notebook.cells}
    page = shown["diagnose"][0]["data"]["text/html"]
    assert page.startswith("<iframe srcdoc=") and "internal-leakage" in page
    compared = shown["charts"][0]["data"]["text/html"]
    assert compared.startswith("<iframe srcdoc=") and "Comparison of" in compared
    assert "internal-leakage" in shown["finding"][0]["text"]
