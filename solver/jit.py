"""Compilation of the physics to machine code; numba is imported here and in ``vectors/`` alone, with the first kernel.

``device``      a function of scalars and small arrays, callable from kernels and from plain Python alike
``generic``     a device function chosen by the *type* of its first argument, a parameter record: its method of the same
                name
``overridable`` the same with a text of its own, for all records that have no such method
``implements``  gives a record of a lower room a method
``kernel``      a compiled loop over particles or nodes, cached on disk

Choosing by type keeps kernels cacheable: a jitted function handed over as an argument, or a kernel made in a
factory, would be compiled anew in every process. The cache directory carries a hash of the whole solver text,
because numba's own cache sees edits in the kernel's file only and would keep returning old physics. A cache serves
every copy of that text (``KernelLocator``) on every processor of its x86-64 level (``_LEVELS``).

Models define no kernels, so that their parameter records are read without numba: what numba has to know of device
and generic functions is registered with the first kernel (``when_compiling``).

Kernels are serial and free of the interpreter lock; threads are given to them from outside (``threads.py``). numba's
own ``prange`` is not used: it loses writes through records (numba#5872), cannot be handed nested records, and took
three times as long to compile (17 s against 5 s for the stress update, numba 0.68). Two rules remain: no raise
(kernels write a status), and no reassociation, so that a NaN stays visible and sums keep their order.
"""

import contextlib
import fcntl
import functools
import gc
import hashlib
import os
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Generic, ParamSpec, Protocol, TextIO, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)
Signature = TypeVar("Signature")
Registration = TypeVar("Registration", bound=Callable[[], None])

# Fused multiply-add is allowed; everything that could hide a NaN or reorder a sum is not. Nobody calls kernels from C:
# wrappers for that take a tenth of the time of compiling (2026-11-25).
_COMMON = {"fastmath": {"contract"}, "error_model": "numpy", "no_cfunc_wrapper": True}
_OPTIONS = {**_COMMON, "forceinline": True}

# s; longer than any kernel compiles: then the process that holds the lock has halted.
_PATIENCE = 60.0
# Held with the lock of a file: kernels that compile others take several locks, in the order of their calls.
_compiling = threading.RLock()
_waiting: list[Callable[[], None]] = []  # registrations until the first kernel
_kernels: set[str] = set()  # names of the functions whose machine code KernelLocator keeps

# numba's own choice, for functions that are no kernels and where the cache directory cannot be made.
_NUMBA_LOCATORS = "UserProvidedCacheLocator,InTreeCacheLocator,UserWideCacheLocator,IPythonCacheLocator"

# LLVM's names of what each level adds: x86-64 psABI, table "Micro-Architecture Levels". The highest comes first.
_V3 = {"avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"}
_LEVELS = {"x86-64-v4": _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}, "x86-64-v3": _V3}


class Record(Protocol):
    """The parameters of a model, a NamedTuple: its type decides which texts of generic functions are compiled."""

    def _asdict(self) -> dict[str, float]: ...


class Kernel(Protocol[P, R_co]):
    """A compiled function."""

    @property
    def py_func(self) -> Callable[P, R_co]:
        """The function as it is written."""

    def __call__(self, *arguments: P.args, **keywords: P.kwargs) -> R_co:
        """Call the machine code for the types of the arguments, compiled unless it is there."""

    def compile(self, signature: tuple[type, ...]) -> Callable[P, R_co]:
        """The machine code for some types of numba."""


def when_compiling(register: Registration) -> Registration:
    """Call a registration with numba as soon as there is a kernel; at once where there is one."""
    if _numba.cache_info().currsize:
        register()
    else:
        _waiting.append(register)
    return register


@functools.cache
def _numba() -> ModuleType:
    """The compiler, with its processor, its cache directory and who finds kernels there."""
    import llvmlite.binding
    import numba.extending

    config = numba.config
    level = _level(llvmlite.binding.get_host_cpu_features())
    if config.CPU_NAME is None and config.CPU_FEATURES is None and level:
        config.CPU_NAME, config.CPU_FEATURES = level, ""
    config.CACHE_DIR = str(_cache_directory(config.CPU_NAME or software()["cpu"]))
    others = config.CACHE_LOCATOR_CLASSES or _NUMBA_LOCATORS
    config.CACHE_LOCATOR_CLASSES = f"{__name__}.{KernelLocator.__name__},{others}"
    return numba


def _level(features: Mapping[str, bool]) -> str | None:
    """The x86-64 level of a processor; None below v3 and for other architectures, which have no such features."""
    has = {name for name, present in features.items() if present}
    return next((level for level, needs in _LEVELS.items() if needs <= has), None)


class KernelLocator:
    """Says where numba keeps a kernel: by module, line and the text of its file, wherever that file is.

    numba's own locators go by the absolute folder. The methods are those of a class that
    ``NUMBA_CACHE_LOCATOR_CLASSES`` names.
    """

    def __init__(self, function: FunctionType, file: str) -> None:
        self._folder = Path(_numba().config.CACHE_DIR) / function.__module__
        text = hashlib.sha256(Path(file).read_bytes()).hexdigest()[:16]
        self._name = f"{function.__code__.co_firstlineno}-{text}"

    @classmethod
    def from_function(cls, function: FunctionType, file: str) -> "KernelLocator | None":
        """The locator of a kernel; None for other functions, and where there can be no folder."""
        if f"{function.__module__}.{function.__qualname__}" not in _kernels:
            return None
        located = cls(function, file)
        try:
            located.ensure_cache_path()
        except OSError:
            return None
        return located

    def ensure_cache_path(self) -> None:
        """Make the folder, before something is written there."""
        self._folder.mkdir(parents=True, exist_ok=True)

    def get_cache_path(self) -> str:
        """The folder of the kernel's files."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Nothing: the text is in the name."""
        return ""

    def get_disambiguator(self) -> str:
        """What tells the kernel from others with its name."""
        return self._name


def device(function: Callable[P, R]) -> Callable[P, R]:
    """A function that kernels may call and that stays a plain Python function outside."""

    @when_compiling
    def register() -> None:
        _numba().extending.register_jitable(**_OPTIONS)(function)

    return function


def generic(declaration: Callable[P, R]) -> Callable[P, R]:
    """A function whose text is the method of its name that the type of its first argument, a record, has."""
    return _chosen_by_type(declaration, None)


def overridable(text: Callable[P, R]) -> Callable[P, R]:
    """A generic function whose own text serves all records that have no such method."""
    return _chosen_by_type(text, text)


def _chosen_by_type(declaration: Callable[P, R], default: Callable[P, R] | None) -> Callable[P, R]:
    name = declaration.__name__

    @functools.wraps(declaration)
    def dispatch(*arguments: P.args, **keywords: P.kwargs) -> R:
        kind = type(arguments[0])
        text: Callable[P, R] = getattr(kind, name, default) if default else getattr(kind, name)
        return text(*arguments, **keywords)

    def choose(record, *arguments):  # by types of numba
        return getattr(getattr(record, "instance_class", None), name, default)

    @when_compiling
    def register() -> None:
        _numba().extending.overload(dispatch, strict=False, jit_options=_OPTIONS)(choose)

    return dispatch


def implements(function: Callable[P, R], record: type) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Make the decorated function the method of a record, of a lower room, that is the text of a generic function."""

    def register(text: Callable[P, R]) -> Callable[P, R]:
        setattr(record, function.__name__, text)
        return text

    return register


def kernel(function: Callable[P, R]) -> Kernel[P, R]:
    """A compiled loop: cached on disk, free of the interpreter lock, IEEE division."""
    numba = _numba()
    while _waiting:
        _waiting.pop(0)()
    name = f"{function.__module__}.{function.__qualname__}"
    _kernels.add(name)
    compiled: Kernel[P, R] = numba.njit(cache=True, nogil=True, **_COMMON)(function)
    if not numba.config.DISABLE_JIT:
        vars(compiled)["compile"] = _compiled_once(compiled.compile, name)
    return compiled


def _compiled_once(compile: Callable[[Signature], R], name: str) -> Callable[[Signature], R]:
    """Compilation under a lock file: a process that needs a kernel waits for the one that compiles it, and loads it."""

    @functools.wraps(compile)
    def locked(signature: Signature) -> R:
        with _compiling, contextlib.ExitStack() as stack:
            # Without the lock, where files cannot be locked, each process compiles for itself.
            with contextlib.suppress(OSError):
                folder = Path(_numba().config.CACHE_DIR)
                folder.mkdir(parents=True, exist_ok=True)
                file = (folder / f"{name}.lock").open("w")
                _lock(stack.enter_context(file))
            # To look for garbage among numba's objects takes a seventh of the time, to keep it 40 MB (2026-11-25).
            if gc.isenabled():
                gc.disable()
                stack.callback(gc.enable)
            try:
                return compile(signature)
            except OSError:  # a folder that can be read alone: compiled and not kept, and this returns it
                return compile(signature)

    return locked


def _lock(file: TextIO) -> None:
    """Lock a file as soon as no other process does; raise ``BlockingIOError`` after ``_PATIENCE``."""
    deadline = time.monotonic() + _PATIENCE
    while True:
        try:
            return fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.02)


class Bound(Generic[P, R]):
    """A kernel bound to the types of its first arguments, for loops in which types do not change.

    It calls the machine code itself: to find it anew by the types of records costs 1 to 8 us a call.
    """

    def __init__(self, function: Kernel[P, R]) -> None:
        self.kernel = function
        self._code: Callable[P, R] | None = None

    def __call__(self, *arguments: P.args, **keywords: P.kwargs) -> R:
        """Call the kernel and return its result."""
        if self._code is None:
            numba = _numba()
            self._code = self.kernel
            if not numba.config.DISABLE_JIT:
                self._code = self.kernel.compile(tuple(map(numba.typeof, arguments)))
        return self._code(*arguments, **keywords)


def software() -> dict[str, str]:
    """Versions of the compiler and the processor, for provenance."""
    import llvmlite.binding
    import numba

    return {"numba": numba.__version__, "cpu": llvmlite.binding.get_host_cpu_name()}


def compiler() -> dict[str, str]:
    """Everything that decides the bits of a kernel except the system's mathematical library."""
    import llvmlite.binding

    config = _numba().config
    settings = (config.CPU_NAME, config.CPU_FEATURES, config.DISABLE_JIT, config.OPT)
    return {
        **software(),
        "cpu_features": llvmlite.binding.get_host_cpu_features().flatten(),
        "llvmlite": llvmlite.__version__,
        "settings": "/".join(map(str, settings)),
        "solver": _text_digest().hexdigest()[:16],
    }


def _cache_directory(processor: str) -> Path:
    root = os.environ.get("WHIPPLE_KERNEL_CACHE") or Path.home() / ".cache" / "whipple"
    digest = _text_digest()
    digest.update(f"{software()['numba']}/{processor}".encode())
    return Path(root) / f"kernels-{digest.hexdigest()[:16]}"


def _text_digest() -> "hashlib._Hash":
    """SHA-256 of the text of ``solver/**/*.py``."""
    digest = hashlib.sha256()
    folder = Path(__file__).parent
    for file in sorted(folder.rglob("*.py")):
        digest.update(file.relative_to(folder).as_posix().encode())
        digest.update(file.read_bytes())
    return digest
