"""Keep compiled kernels in one folder, each file named by the sources that its code is made of.

Numba's own cache keeps a compiled kernel as long as the file that the kernel stands in is unchanged, even when
another file, whose functions it inlines, has changed. Here, the name holds a checksum of the kernel's file and of all
that this one imports from, so a change is compiled where it counts and nowhere else. Each file has a checksum of its
content. Numba's settings are not touched: a `KernelCache` stands in the dispatcher where Numba's own would stand, so
that functions of others are cached where Numba puts them.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import re
import shutil
import sys
import time
import uuid
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import llvmlite.binding
import numba
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from riglens.core.cache_folder import cache_folder, tell_damaged
from riglens.core.kernels.runtime.linked import is_for_a_caller

PREFIX = "riglens-kernels-"
OLD_S = 14 * 24 * 3600.0
"""Code of other sources is removed when it has not been used for this long."""
SOURCES = Path(__file__).parents[1]
PACKAGE = "riglens.core.kernels"
CHECKSUM_BYTES = 32
_IMPORTED = re.compile(rb"^from riglens\.core\.kernels\.(\w+)(\.\w+)? import", re.MULTILINE)


class Sources:
    """The source files of all kernels, as they are now.

    They are read at once, not when a kernel is needed: sources that change while a program runs do not change the
    code that it has imported.
    """

    def __init__(self, folder: Path = SOURCES) -> None:
        self.folder = folder
        self._texts = {
            ".".join(path.relative_to(folder).with_suffix("").parts): path.read_bytes()
            for path in sorted(folder.rglob("*.py"))
        }
        self._digests: dict[str, str] = {}

    def needed_by(self, module: str) -> tuple[str, ...]:
        """Return the module itself and all that its kernels take functions and constants from, in order.

        Modules are named as inside the package: "rays.walk".
        """
        found, ahead = set[str](), {module}
        while ahead:
            found |= ahead
            imported = {name for one in ahead for name in self._imported_by(one)}
            ahead = imported - found
        return tuple(sorted(found))

    def _imported_by(self, module: str) -> set[str]:
        names = {(room + file).decode() for room, file in _IMPORTED.findall(self._texts[module])}
        return names & self._texts.keys()

    def digest_of(self, module: str) -> str:
        """Return the digest of a module's kernels: of the text of all files that their code is made of."""
        if module not in self._digests:
            self._digests[module] = self._digest(self.needed_by(module))
        return self._digests[module]

    @cached_property
    def digest(self) -> str:
        """Return a digest of the code of all kernels together."""
        return self._digest(tuple(self._texts))

    def _digest(self, modules: tuple[str, ...]) -> str:
        digest = hashlib.sha256()
        for module in modules:
            text = self._texts[module]
            digest.update(f"\n{module} {len(text)}\n".encode() + text)
        return digest.hexdigest()[:20]


class KernelFolder:
    """The folder of compiled code for this version of Numba. It is created when a kernel is first loaded or
    compiled."""

    def __init__(self, sources: Path = SOURCES) -> None:
        self.sources = Sources(sources)
        self.name = PREFIX + f"numba-{numba.__version__}"
        self._has_saved = False

    @cached_property
    def path(self) -> Path | None:
        """Return the folder, created and marked as used; None where it cannot be created."""
        return next((root / self.name for root in self._roots() if _is_usable(root / self.name)), None)

    def _roots(self) -> Iterator[Path]:
        """Yield the candidate folders, the best first; next to the sources where the user has no cache."""
        if numba.config.CACHE_DIR:
            yield Path(numba.config.CACHE_DIR)
        yield cache_folder()
        yield self.sources.folder / "__pycache__"

    def read(self, name: str) -> bytes | None:
        """Return the content of a file; None when it is absent, or damaged, which is noted: it is compiled again."""
        if self.path is None or not (self.path / name).is_file():  # a pipe would be waited for
            return None
        try:
            stored = (self.path / name).read_bytes()
            os.utime(self.path / name)
        except OSError:
            return None
        content = stored[CHECKSUM_BYTES:]
        if stored[:CHECKSUM_BYTES] == hashlib.sha256(content).digest():
            return content
        tell_damaged(self.path, "compiled kernels")
        return None

    def write(self, name: str, content: bytes) -> None:
        """Put a file in place in one step; where that fails, the next process compiles again."""
        if self.path is None:
            return
        if not self._has_saved:
            self._has_saved = True
            _remove_old(self.path)
        unfinished = self.path / f"{name}.{uuid.uuid4().hex[:16]}"
        try:
            unfinished.write_bytes(hashlib.sha256(content).digest() + content)
            unfinished.replace(self.path / name)
        except OSError:
            with contextlib.suppress(OSError):
                unfinished.unlink()


class KernelCache:
    """Cache of compiled code for Numba's dispatcher of one kernel, in place of `numba.core.caching.FunctionCache`.

    One file holds the code for one tuple of argument types, to be called or only to be linked.
    """

    def __init__(self, folder: KernelFolder, py_func: Any) -> None:
        self._folder = folder
        module = py_func.__module__.removeprefix(f"{PACKAGE}.")
        name = py_func.__qualname__.replace("<", "").replace(">", "")  # not allowed on Windows
        self._name = f"{module}.{name}-{folder.sources.digest_of(module)}"

    @property
    def cache_path(self) -> str | None:
        """The folder, for `dispatcher.stats`."""
        return str(self._folder.path) if self._folder.path else None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the `CompileResult` for these argument types; None when it is not in the cache."""
        target_context.refresh()
        made_for = (sig, target_context.codegen().magic_tuple(), is_for_a_caller())
        stored = self._folder.read(self._file_name(made_for))
        if stored is None:
            return None
        found, parts = pickle.loads(stored)
        if found != made_for:
            return None
        result = CompileResult._rebuild(target_context, *parts)
        _, kind, content = parts[0]
        if kind == "object":
            _parse_when_linked(result.library, content[1])
        return result

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a `CompileResult`, unless its code holds addresses of this process."""
        if not data.library.has_dynamic_globals:
            made_for = (sig, data.codegen.magic_tuple(), is_for_a_caller())
            self._folder.write(self._file_name(made_for), dumps((made_for, data._reduce())))

    def _file_name(self, made_for: tuple[Any, Any, bool]) -> str:
        """Argument types, processor and Python's version in a name of bounded length."""
        key = hashlib.sha256(f"{made_for} {sys.implementation.cache_tag}".encode()).hexdigest()[:20]
        return f"{self._name}-{key}.nbc"


def _parse_when_linked(library: Any, bitcode: bytes) -> None:
    """Drop the parsed code of a kernel from disk, which only a kernel that is compiled later, and calls it, needs: half
    a megabyte each."""

    def module() -> Any:
        if library._shared_module is None:
            library._shared_module = llvmlite.binding.parse_bitcode(bitcode)
        return library._shared_module

    library._shared_module, library._get_module_for_linking = None, module


def _is_usable(folder: Path) -> bool:
    """Return whether files can be written there; mark it as used now."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def _remove_old(used: Path) -> None:
    """Remove folders of other versions, and long unused code of other sources in this one; another process may do the
    same."""
    long_ago = time.time() - OLD_S
    for other in (*used.parent.glob(PREFIX + "*"), *used.glob("*")):
        with contextlib.suppress(OSError):
            if other == used or other.stat().st_mtime >= long_ago:
                continue
            if other.is_dir():
                shutil.rmtree(other, ignore_errors=True)
            else:
                other.unlink()
