"""Data flows one way: a folder imports only those above it, and heavy packages load late."""

from __future__ import annotations

import ast
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import pivotgait

PACKAGE = Path(pivotgait.__file__).parent
LAYERS = (
    "exceptions",
    "frozen",
    "atomic",
    "models",
    "plans",
    "contacts",
    "dynamics",
    "kinematics",
    "forces",
    "margins",
    "planning",
    "phases",
    "gaits",
    "certification",
    "control",
    "validation",
    "pytest_plugin",
    "feasibility",
    "gait_search",
    "sweeps",
    "plotting",
    "reporting",
    "viewing",
    "benchmarks",
    "commands",
    "cli",
    "__main__",
)
"""From top to bottom; a layer may import itself and what stands before it."""
CERTIFICATION_MAY_IMPORT = {
    "certification",
    "exceptions",
    "frozen",
    "models",
    "plans",
    "kinematics",
}
SOLVERS = {"casadi", "clarabel", "cvxpy", "proxsuite", "osqp", "scs"}
SOLVER_LAYERS = {"forces", "phases", "benchmarks"}
SIMULATORS = {"pybullet", "pybullet_data", "pybullet_utils", "mujoco"}
PICTURES = {"matplotlib", "mpl_toolkits"}
MODULES = sorted(PACKAGE.rglob("*.py"))


def layer_of(file: Path) -> str:
    """Folder (or top-level module) of the package that a file belongs to."""
    return file.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(file: Path) -> Iterator[tuple[str, bool]]:
    """Absolute name of each import and whether it runs when the module is imported."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    yield from _imports(tree, at_import=True)


def _imports(node: ast.AST, *, at_import: bool) -> Iterator[tuple[str, bool]]:
    for child in ast.iter_child_nodes(node):
        inside = at_import and not _is_deferred(child)
        if isinstance(child, ast.Import):
            yield from ((alias.name, at_import) for alias in child.names)
        elif isinstance(child, ast.ImportFrom):
            assert child.level == 0, f"relative import at line {child.lineno}"
            names = [alias.name for alias in child.names]
            # `from pivotgait import plans` names the folder in the alias.
            whole = [f"pivotgait.{name}" for name in names]
            yield from (
                (n, at_import)
                for n in (whole if child.module == "pivotgait" else [child.module or ""])
            )
        else:
            yield from _imports(child, at_import=inside)


def _is_deferred(node: ast.AST) -> bool:
    """Function bodies run later; blocks for type checkers never."""
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
        return True
    return isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)


def identity(file: Path) -> str:
    return str(file.relative_to(PACKAGE))


@pytest.mark.parametrize("file", MODULES, ids=identity)
def test_layers_import_upwards_only(file: Path) -> None:
    layer = layer_of(file)
    if layer == "__init__":
        assert not [name for name, _ in imports(file) if name.startswith("pivotgait.")]
        return
    assert layer in LAYERS, f"{layer} has no place in the order of layers"
    allowed = set(LAYERS[: LAYERS.index(layer) + 1]) | {"__version__"}
    if layer == "certification":
        allowed = CERTIFICATION_MAY_IMPORT
    for name, _ in imports(file):
        if name.startswith("pivotgait."):
            target = name.split(".")[1]
            assert target in allowed, f"{layer} may not import {name}"


@pytest.mark.parametrize("file", MODULES, ids=identity)
def test_heavy_packages_stay_where_they_belong(file: Path) -> None:
    layer = layer_of(file)
    for name, at_import in imports(file):
        root = name.split(".")[0]
        if root in SOLVERS:
            allowed = layer in SOLVER_LAYERS or identity(file) == "commands/doctor.py"
            assert allowed, f"{layer} imports the solver {root}"
            assert not at_import, f"{root} must be imported inside the function that uses it"
        if root in SIMULATORS:
            engine_file = layer == "validation" and file.stem.endswith("_")
            assert engine_file, f"only validation/*_.py import simulators, not {root}"
            assert not at_import, f"{root} must be imported inside the function that uses it"
        if root in PICTURES:
            assert layer == "plotting", f"{layer} imports {root}; drawing belongs to plotting"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("import casadi", [("casadi", True)]),
        ("def f():\n    import casadi", [("casadi", False)]),
        ("class A:\n    import casadi", [("casadi", True)]),
        ("try:\n    import casadi\nexcept ImportError:\n    pass", [("casadi", True)]),
        (
            "from pivotgait import plans, phases",
            [("pivotgait.plans", True), ("pivotgait.phases", True)],
        ),
        ("if TYPE_CHECKING:\n    import casadi", [("casadi", False)]),
    ],
)
def test_the_reader_of_imports_sees_them(tmp_path: Path, text: str, found: list) -> None:
    file = tmp_path / "module.py"
    file.write_text(text)
    assert list(imports(file)) == found


def test_modules_were_found() -> None:
    assert {"plans", "certification", "contacts"} <= {layer_of(file) for file in MODULES}


def _seconds(code: str) -> float:
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    return time.perf_counter() - start


def test_package_imports_fast() -> None:
    bare = min(_seconds("pass") for _ in range(3))
    ours = min(_seconds("import pivotgait") for _ in range(3))
    assert ours - bare < 0.3


@pytest.mark.parametrize("module", ["pivotgait", "pivotgait.exceptions", "pivotgait.plans"])
def test_light_modules_load_nothing_heavy(module: str) -> None:
    code = f"import sys, {module}; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    loaded = {name.split(".")[0] for name in run.stdout.split()}
    heavy = SOLVERS | SIMULATORS | PICTURES | {"pinocchio", "coal", "h5py", "pydantic"}
    assert not loaded & heavy
