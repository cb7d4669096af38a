"""Ranks: one run by several processes, of which the first leads and the others work for it.

    mpiexec -n 4 masonry-fem run SCENE.toml

The *leader* runs the program as a single process would. Where work can be split it calls on all ranks, itself
among them; the others wait for nothing else. So there is one course of events, one output, and one place
where errors end up.

    shares = [...]                                # what each rank needs, the leader's first
    results = team().call(work, shares)           # work(member, share) on all ranks, together

    def work(member, share):
        own = member.together(lambda: ...)        # what may fail on one rank: then it fails on all
        return member.comm.allreduce(...)         # what cannot be done by one rank alone

In the midst of work the leader can call on all ranks for other work, if these serve meanwhile:

    def work(member, share):
        given = member.collected(...)             # what all ranks have, on the leader; None elsewhere
        if given is None:
            return member.serve()                 # until the leader hands out what it has made of that
        return team().lead(lambda: [...])         # for each rank; calls on ranks may lead there

In a process that was started alone there is no team but ``Alone``, and no MPI is loaded.
"""

from __future__ import annotations

import gc
import importlib.util
import logging
import os
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

from masonry_fem.errors import InstallationError
from masonry_fem.host.memory import peak_memory

if TYPE_CHECKING:  # the command line reads this file
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

# What tells a process of how many it is one, by whatever started it: MPICH and Intel MPI, Open MPI.
COUNTS = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE")
# Threads that libraries start where nobody says how many: one for each core, whatever other ranks do. On two
# cores two ranks with two threads each take 30 s to solve 40×40 bricks, with one each 3.3 s.
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
# Children of a rank are no ranks.
INHERITED = ("PMI_", "PMIX_", "OMPI_", "HYDI_", "MPI_LOCAL")
OUT, IN = "handed out", "handed in"
HANDING = frozenset({OUT, IN})  # kinds of work that are no more than the leader's call
EAGER, NAP = 200, 1e-4  # looks for other ranks without a pause, and the pause between further ones [s]
HEARD = 0.5  # seconds in which mpiexec reads what a rank has said

Work = Callable[["Member", Any], Any]


@dataclass(slots=True)
class Spent:
    """What a rank has spent on one kind of work.

    Attributes
    ----------
    seconds, wall : CPU time, in which MPI waits for other ranks, and wall-clock time [s].
    received : Bytes that came from other ranks.
    times : How often some came.
    """

    seconds: float = 0.0
    wall: float = 0.0
    received: int = 0
    times: int = 0


@dataclass(slots=True)
class Member:
    """One of the ranks, as work sees it.

    Attributes
    ----------
    comm : Communicator of all ranks. direct : The same, which sends large arrays from where they are.
    kept : What work leaves for further work on this rank, by name.
    spent : By kind of work.
    """

    comm: Any
    kept: dict[str, Any] = field(default_factory=dict)
    spent: dict[str, Spent] = field(default_factory=dict)
    direct: Any = field(init=False)

    def __post_init__(self) -> None:
        self.direct = import_module("mpi4py.util.pkl5").Intracomm(self.comm)

    @property
    def rank(self) -> int:
        """Its number; 0 leads."""
        return int(self.comm.rank)

    @property
    def size(self) -> int:
        """How many ranks there are."""
        return int(self.comm.size)

    @contextmanager
    def on(self, kind: str, received: int = 0) -> Iterator[None]:
        """Count what is done within the context.

        Parameters
        ----------
        kind : Of work. received : Bytes that come from other ranks in it.
        """
        began, wall = time.process_time(), time.monotonic()
        try:
            yield
        finally:
            spent = self.spent.setdefault(kind, Spent())
            spent.seconds += time.process_time() - began
            spent.wall += time.monotonic() - wall
            spent.received += received
            spent.times += received > 0

    def send(self, given: Any, rank: int) -> None:
        """Hand something to another rank, which ``receive``s it.

        Parameters
        ----------
        given : Whatever can be pickled. rank : The other one.
        """
        with self.on(OUT if self.rank == 0 else IN):
            self.direct.send(given, rank)

    def receive(self, rank: int) -> Any:
        """What another rank sends.

        Parameters
        ----------
        rank : The other one.
        """
        kind, mpi = IN if self.rank == 0 else OUT, import_module("mpi4py.MPI")
        status = mpi.Status()
        with self.on(kind):
            given = self.direct.recv(source=rank, status=status)
        self.spent[kind].received += status.Get_elements(mpi.BYTE)
        return given

    def serve(self) -> Any:
        """Do what the leader calls for, until it sends what this rank was waiting for: that.

        Raises
        ------
        AgreedError : The leader has failed to make it.
        """
        while True:
            self.meet()
            work, share = self.receive(0)
            if work is None:
                if isinstance(share, _Failure):
                    raise AgreedError(share.error)
                return share
            made = _done(work, self, share)[0]
            del share
            self.meet()
            self.send(made, 0)

    def collected(self, given: Any) -> list[Any] | None:
        """What all ranks have given, where this one leads; None elsewhere.

        Parameters
        ----------
        given : Whatever can be pickled.
        """
        if self.rank:
            self.send(given, 0)
            return None
        return [given, *(self.receive(rank) for rank in range(1, self.size))]

    def summed(self, values: Array) -> Array:
        """Sums over all ranks of what each has, number by number: the same bits on each.

        Parameters
        ----------
        values : An array of the same shape on all ranks.
        """
        if self.size == 1:
            return values
        import numpy as np  # noqa: PLC0415 - the command line reads this file

        with self.on("exchange", values.nbytes):
            summed = np.empty_like(values)
            self.comm.Allreduce(np.ascontiguousarray(values), summed)
            return summed

    def everyone(self, values: Array) -> Array:
        """What each rank has, rank after rank, shape (size, ...).

        Parameters
        ----------
        values : An array of the same shape on all ranks.
        """
        import numpy as np  # noqa: PLC0415 - the command line reads this file

        with self.on("exchange", values.nbytes * (self.size - 1)):
            found = np.empty((self.size, *values.shape))
            self.comm.Allgather(np.ascontiguousarray(values), found)
            return found

    def joined(self, rows: Array) -> Array:
        """The rows of all ranks, rank after rank.

        Parameters
        ----------
        rows : Of this rank, shape (n, k).
        """
        if self.size == 1:
            return rows
        import numpy as np  # noqa: PLC0415 - the command line reads this file

        counts = self.everyone(np.array([float(rows.size)])).ravel().astype(int)
        with self.on("exchange", int(counts.sum() - rows.size) * rows.itemsize):
            found = np.empty((counts.sum() // rows.shape[1], rows.shape[1]))
            self.comm.Allgatherv(np.ascontiguousarray(rows), [found, counts])
            return found

    def meet(self) -> None:
        """Wait until all ranks are here."""
        self.wait(self.comm.Ibarrier())

    def wait(self, request: Any) -> None:
        """Wait for what MPI does, without keeping a processor busy for long as MPI would.

        Parameters
        ----------
        request : Of a call that does not wait itself.
        """
        looks = 0
        while not request.Test():
            looks += 1
            if looks > EAGER:
                time.sleep(NAP)

    def together(self, local: Callable[[], Any]) -> Any:
        """What a function gives that asks nothing of other ranks; where it fails on one, this fails on all.

        Raises
        ------
        AgreedError : With what the first rank on which it failed has raised.
        """
        made, failure = None, None
        try:
            made = local()
        except Exception as error:
            failure = error
        self.meet()
        for told in self.comm.allgather(failure):
            if told is not None:
                raise AgreedError(told)
        return made


class Alone:
    """A process that was started alone."""

    size = 1

    def spent(self) -> list[tuple[dict[str, Spent], float]]:
        """What each rank has spent by kind of work, and its peak memory [MB]; empty: there is one process."""
        return []

    def end(self, code: int) -> None:
        """Let all ranks end."""


class Leader(Alone):
    """The first of several ranks.

    Parameters
    ----------
    comm : Communicator of all.

    Attributes
    ----------
    held : What callers know of what ranks keep, by the same names.
    busy : Ranks are at work that they were called for, or were left in the midst of it:
        there can be no other call.
    """

    def __init__(self, comm: Any) -> None:
        self.size = int(comm.size)
        self.held: dict[str, Any] = {}
        self._member = Member(comm)
        self.busy = False

    def call(self, work: Work, shares: Sequence[Any]) -> list[Any]:
        """Results of all ranks.

        Parameters
        ----------
        work : A function of a module, which other ranks find by its name.
        shares : What it is given on each rank.

        Raises
        ------
        Exception : What ``together`` has raised.
        """
        self.busy = True
        self._member.meet()
        for rank, share in enumerate(shares[1:], start=1):
            self._member.send((work, share), rank)
        made, failure = _done(work, self._member, shares[0])
        self._member.meet()
        results = [made, *(self._member.receive(rank) for rank in range(1, self.size))]
        self.busy = False
        if failure is not None:
            raise failure
        return results

    def lead(self, local: Callable[[], Sequence[Any]]) -> Any:
        """In the midst of work: lead ranks that ``serve`` meanwhile, and hand them what they wait for.

        Parameters
        ----------
        local : Makes what each rank gets; it may call on them.

        Raises
        ------
        AgreedError : With what it has raised.
        """
        shares: Sequence[Any]
        self.busy = False
        try:
            shares = local()
        except Exception as error:
            if self.busy:  # others are in the midst of other work
                raise
            shares = [_Failure(error)] * self.size
        finally:
            self.busy = True
        self._member.meet()
        for rank, share in enumerate(shares[1:], start=1):
            self._member.send((None, share), rank)
        if isinstance(shares[0], _Failure):
            raise AgreedError(shares[0].error)
        return shares[0]

    def spent(self) -> list[tuple[dict[str, Spent], float]]:
        """What each rank has spent by kind of work, and its peak memory [MB], the leader first."""
        return self.call(_spent, [None] * self.size)

    def end(self, code: int) -> None:
        """Let all ranks end; where one was left in the midst of work, with an exit code and at once."""
        comm = self._member.comm
        if self.busy:
            _abort(comm, code)
        self._member.meet()
        for rank in range(1, self.size):
            self._member.send((None, None), rank)
        self._member.kept.clear()


def dealt(sizes: Sequence[float] | NDArray[Any], ranks: int) -> list[list[int]]:
    """Numbers of the works that each rank does: the largest first, each for the one that has least.

    Parameters
    ----------
    sizes : Of each work. ranks : How many there are.
    """
    its: list[list[int]] = [[] for _ in range(ranks)]
    load = [0.0] * ranks
    for number in sorted(range(len(sizes)), key=lambda work: -sizes[work]):
        rank = load.index(min(load))
        its[rank].append(number)
        load[rank] += float(sizes[number])
    return its


_team: Alone | Leader = Alone()


def team() -> Alone | Leader:
    """The ranks that this process leads."""
    return _team


def join(fewest: int = 2) -> bool:
    """Meet the other ranks, if there are any; True on all but the one that leads.

    Called before NumPy is loaded, it sees to it that each of several ranks has one thread, unless the
    environment says how many.

    Parameters
    ----------
    fewest : Ranks from which there is a team; 1: whatever mpiexec has started.

    Raises
    ------
    InstallationError : MPI or PETSc is missing, or is another one than that which has started this process.
    """
    global _team  # noqa: PLW0603 - a fact of this process
    started = max(int(os.environ.get(name) or 0) for name in COUNTS)
    if started < fewest:
        return False
    for name in THREADS if started > 1 else ():
        os.environ.setdefault(name, "1")
    comm = _communicator(started)
    for name in list(os.environ):
        if name.startswith(INHERITED):
            del os.environ[name]
    if comm.rank:
        _serve(Member(comm))
        return True
    _team = Leader(comm)
    return False


def _communicator(started: int) -> Any:
    """That of all ranks; PETSc is loaded on all of them at once, as it has to be."""
    os.environ.setdefault("MPIR_CVAR_SUPPRESS_ABORT_MESSAGE", "1")
    try:
        if importlib.util.find_spec("dolfinx_solver") is not None:
            import_module("dolfinx_solver")  # the wheel's loader must come before mpi4py
        mpi = import_module("mpi4py.MPI")
        import_module("petsc4py.PETSc")
    except (ImportError, RuntimeError) as missing:
        raise InstallationError(
            f"started as one of {started} ranks, but MPI or PETSc cannot be loaded ({missing}); install the "
            "'fenicsx' extra, or start a single process without mpiexec"
        ) from missing
    comm = mpi.COMM_WORLD
    if comm.size != started:
        raise InstallationError(
            f"started as one of {started} ranks, but MPI ({mpi.get_vendor()[0]}) sees {comm.size}; use the "
            "mpiexec that belongs to it, which stands beside this Python"
        )
    return comm


def _serve(member: Member) -> None:
    """Do what the leader calls for, until it ends; nothing else ends this rank, and it says nothing."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # the leader answers for all
    logging.getLogger("masonry_fem").setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore")
    try:
        member.serve()
    except BaseException as error:  # others wait for this rank in the midst of work
        print(f"masonry-fem: rank {member.rank}: {_said(error)}", file=sys.stderr, flush=True)
        _abort(member.comm, 1)
    member.kept.clear()
    gc.collect()


def _abort(comm: Any, code: int) -> None:
    """End all ranks at once, when what was said has been read: mpiexec drops what it has not read by then."""
    sys.stderr.flush()
    time.sleep(HEARD)
    comm.Abort(code)


def _done(work: Work, member: Member, share: Any) -> tuple[Any, Exception | None]:
    """What work gives, or what all ranks agree that has failed."""
    try:
        return work(member, share), None
    except AgreedError as failure:
        return None, failure.error


def _said(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return "memory is not enough for its part of this scene; take more ranks, or fewer on each machine"
    return f"unexpected {type(error).__name__}: {error}"


@dataclass(frozen=True, slots=True)
class _Failure:
    """What ranks get that wait for something which cannot be made."""

    error: Exception


class AgreedError(Exception):
    """All ranks know that one has failed, and how: ``error``."""

    def __init__(self, error: Exception) -> None:
        super().__init__(str(error))
        self.error = error


def _spent(member: Member, _: None) -> tuple[dict[str, Spent], float]:
    return member.spent, peak_memory()
