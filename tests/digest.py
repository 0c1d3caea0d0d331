"""Digests of everything that the command line prints and writes: do they change no figure in a restructuring?

    python -m tests.digest --out before.json                # in the old checkout; texts go to before.d/
    python -m tests.digest --out after.json                 # in the new one, or with --checkout FOLDER
    python -m tests.digest --compare before.json after.json # exit code 1 when an item differs or is missing

Every item (`digest_items.py`) runs through the public `main` in an empty folder; what it prints and every file that it
leaves are its text. Compiled kernels stay in the user's cache, everything else is made anew. --data FOLDER
adds real data sets.
"""

from __future__ import annotations

import argparse
import fnmatch
import hashlib
import importlib
import io
import json
import multiprocessing
import os
import re
import shlex
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from tests.digest_items import Item, items, write_inputs

MAX_TEXT = 4_000_000
"""Larger texts, and binary files, are kept as a hash only."""
VOLATILE = (
    (re.compile(r'("elapsed_ms": *)[-+.e\d]+'), r"\g<1>0"),
    (re.compile(r'((?:"version": *"|RigLens )v?)\d+\.\d+[\w.+-]*\b'), r"\g<1>VERSION"),
    (re.compile(r"\b20\d\d-\d\d-\d\d([T ]\d\d:\d\d(:\d\d(\.\d+)?)?)?"), "DATE"),
)


# ---------------------------------------------------------------- running

Captured = tuple[int, str, str]


def run_group(group: list[Item], root: Path, checkout: Path) -> list[tuple[str, int, str, float]]:
    """Run items in this process; return name, last exit code, text and seconds of each."""
    sys.path.insert(0, str(checkout))
    package = importlib.import_module("riglens")
    if Path(str(package.__file__)).resolve().parents[1] != checkout:
        raise SystemExit(f"digest: {package.__file__} is not of {checkout}")
    main = importlib.import_module("riglens.app.commands").main
    found = []
    for item in group:
        folder, started, code, parts = root / hash_of(item.name.encode())[:12], time.monotonic(), 0, []
        folder.mkdir()
        os.chdir(folder)
        for command in item.commands:
            code, out, err = captured(main, shlex.split(command))
            parts.append(f"$ riglens {command}\nexit {code}\n--- stdout\n{out}--- stderr\n{err}")
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            parts.append(f"--- file {path.relative_to(folder)}\n{content(path, root)}\n")
        text = steady("\n".join(parts), root)
        os.chdir(root)
        shutil.rmtree(folder)
        found.append((item.name, code, text, time.monotonic() - started))
    return found


def captured(main: Callable[[list[str]], int], words: list[str]) -> Captured:
    """Return exit code, standard output and standard error, also of native code."""
    kept = os.dup(1), os.dup(2)
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        try:
            code = main(words)
        except BaseException:
            code = -1
            traceback.print_exc(limit=0)
        sys.stdout.flush()
        sys.stderr.flush()
        for number, stream in enumerate(kept, 1):
            os.dup2(stream, number)
            os.close(stream)
        out.seek(0)
        err.seek(0)
        return code, out.read().decode(errors="replace"), err.read().decode(errors="replace")


def content(path: Path, root: Path) -> str:
    """Return the content of a file as text where possible: arrays and tables by values, pictures by pixels."""
    data: bytes = path.read_bytes()
    if path.suffix == ".npz":
        arrays: Any = importlib.import_module("numpy").load(path)
        return "\n".join(f"{k} {v.dtype} {v.shape} {hash_of(v.tobytes())}" for k, v in sorted(arrays.items()))
    if path.suffix == ".parquet":
        table: Any = importlib.import_module("pyarrow.parquet").read_table(path)
        as_csv = io.BytesIO()
        importlib.import_module("pyarrow.csv").write_csv(table, as_csv)
        data = (
            "\n".join(f"{field.name} {field.type}" for field in table.schema).encode()
            + b"\n"
            + as_csv.getvalue()
        )
    if path.suffix in (".png", ".jpg"):
        picture: Any = importlib.import_module("PIL.Image").open(path)
        return f"{picture.mode} {picture.size} {hash_of(picture.tobytes())}"
    try:
        text = data.decode()
    except UnicodeDecodeError:
        return f"{len(data)} bytes {hash_of(data)}"
    text = re.sub(r"(data:[\w/+]+;base64,)([\w+/=]{200,})", lambda m: m[1] + hash_of(m[2].encode()), text)
    text = steady(text, root)
    return text if len(text) <= MAX_TEXT else f"{len(text)} characters {hash_of(text.encode())}"


def steady(text: str, root: Path) -> str:
    """Return a text without times, dates, versions and the name of the temporary folder."""
    text = text.replace(str(root), "ROOT")
    for pattern, put in VOLATILE:
        text = pattern.sub(put, text)
    return text


def hash_of(data: bytes) -> str:
    """Return the SHA-256 in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def make(out: Path, patterns: list[str], jobs: int, checkout: Path, data: Path | None) -> None:
    """Run all items whose name fits a pattern, and write the digests and, beside them, the texts."""
    groups: dict[str, list[Item]] = {}
    for item in items(data):
        if any(fnmatch.fnmatch(item.name, pattern) for pattern in patterns):
            groups.setdefault(item.group, []).append(item)
    texts, started = out.with_suffix(".d"), time.monotonic()
    shutil.rmtree(texts, ignore_errors=True)
    texts.mkdir(parents=True)
    digests: dict[str, dict[str, str | int]] = {}
    with tempfile.TemporaryDirectory(prefix="digest-") as temporary:
        root = Path(temporary).resolve()
        (root / "in").mkdir()
        write_inputs(root / "in")
        set_environment(root, checkout)
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(jobs, context, max_tasks_per_child=1) as pool:
            for done in as_completed(
                [pool.submit(run_group, group, root, checkout) for group in groups.values()]
            ):
                for name, code, text, seconds in done.result():
                    digests[name] = {"sha256": hash_of(text.encode()), "exit": code}
                    (texts / (re.sub(r"[^\w.+-]+", "-", name) + ".txt")).write_text(text, encoding="utf-8")
                    print(f"{time.monotonic() - started:6.1f} {seconds:5.1f} s  {code:2}  {name}", flush=True)
    out.write_text(json.dumps(dict(sorted(digests.items())), indent=0) + "\n", encoding="utf-8")
    print(f"{len(digests)} items in {time.monotonic() - started:.0f} s: {out}")


def set_environment(root: Path, checkout: Path) -> None:
    """Set what worker processes inherit: of the user only the compiled kernels; two threads; no display."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "riglens"
    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache))
    os.environ.setdefault("NUMBA_NUM_THREADS", "2")
    folders = {f"RIGLENS_{name}_DIR": str(root / name.lower()) for name in ("CACHE", "CONFIG", "STATE")}
    os.environ |= folders | {
        "PYTHONPATH": str(checkout),
        "COLUMNS": "120",
        "TERM": "dumb",
        "QT_QPA_PLATFORM": "offscreen",
    }
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "RIGLENS_LIBRARY", "FORCE_COLOR"):
        os.environ.pop(name, None)


def compare(before: Path, after: Path) -> int:
    """Print the items that differ or are missing; 1 when there are any."""
    one, other = (json.loads(path.read_text(encoding="utf-8")) for path in (before, after))
    lines = [f"only in {before}: {name}" for name in one.keys() - other.keys()]
    lines += [f"only in {after}: {name}" for name in other.keys() - one.keys()]
    lines += [f"differs: {name}" for name in one.keys() & other.keys() if one[name] != other[name]]
    print("\n".join([*sorted(lines), f"{len(lines)} of {len(one.keys() | other.keys())} items differ"]))
    return int(bool(lines))


def main() -> int:
    """Write or compare digests."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, help="write digests to FILE.json, texts to FILE.d")
    parser.add_argument(
        "--only", action="append", metavar="PATTERN", help="items whose name fits ('W+T *'); may be repeated"
    )
    parser.add_argument("--jobs", type=int, default=2, help="processes at the same time (2)")
    parser.add_argument(
        "--checkout", type=Path, default=Path.cwd(), help="the program to run (the current folder)"
    )
    parser.add_argument("--data", type=Path, help="folder with the real data sets, for further items")
    parser.add_argument("--compare", type=Path, nargs=2, metavar=("BEFORE", "AFTER"))
    asked = parser.parse_args()
    if asked.compare:
        return compare(*asked.compare)
    if asked.out is None:
        parser.error("--out or --compare is needed")
    data = asked.data.resolve() if asked.data else None
    make(asked.out.resolve(), asked.only or ["*"], asked.jobs, asked.checkout.resolve(), data)
    return 0


if __name__ == "__main__":
    sys.exit(main())
