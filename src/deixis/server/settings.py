"""What a server may be told, and its limits."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from deixis.parallel import WORKERS


@dataclass(frozen=True, slots=True)
class Limits:
    """How much one request, and all of them together, may take.

    Attributes
    ----------
    timeout : float
        Seconds a question may take; what takes longer is killed.
    memory : int
        Bytes a question may take beyond the data.
    rows : int
        Rows or triples of an answer.
    answer : int
        Bytes of an answer.
    body : int
        Bytes of what is sent.
    upload_seconds : float
        Seconds in which all of it must come.
    head : int
        Bytes of a request before its body.
    head_seconds : float
        Seconds in which these must come, and for which a connection is kept without a request.
    send_seconds : float
        Seconds after which a client that reads less than 1 KiB a second is hung up on.
    connections : int
        Connections at the same time; one more, and the one that is waited for longest is closed.
    text : int
        Characters of a query.
    depth : int
        Brackets within brackets of a query.
    workers : int
        Questions answered at the same time, of those whose texts were quick before.
    newcomers : int
        Questions answered beside them that were not asked before.
    slow : int
        Slow questions answered beside them.
    patience : float
        Seconds of the processor's time after which a question is slow: it goes on with the least priority.
    queue : int
        Questions that may wait; more are told to come back (429).
    scenes_awake : int
        Scenes whose reasons (``ask``, ``why``) are kept ready, and as many that are kept ready for updates.
    updates : int
        Updates of scenes that may wait; more are told to come back (429).
    streams : int
        Clients that follow the changes of scenes at the same time; more are told to come back (429).
    heartbeat : float
        Seconds after which they are told that nothing happened.
    event : int
        Bytes of one event; what is larger is told as: reload.
    kept : int
        Bytes of events that are kept of each scene, for clients that were away or read slowly.
    """

    timeout: float = 10.0
    memory: int = 1 << 30
    rows: int = 10_000
    answer: int = 1 << 26
    body: int = 1 << 24
    upload_seconds: float = 30.0
    head: int = 1 << 16
    head_seconds: float = 10.0
    send_seconds: float = 10.0
    connections: int = 1024
    text: int = 1 << 16
    depth: int = 64
    workers: int = WORKERS + 1
    newcomers: int = WORKERS
    slow: int = 4
    patience: float = 0.02
    queue: int = 256
    scenes_awake: int = 4
    updates: int = 32
    streams: int = 256
    heartbeat: float = 15.0
    event: int = 1 << 18
    kept: int = 1 << 20


@dataclass(frozen=True, slots=True)
class Settings:
    """What a server may be told.

    Attributes
    ----------
    host, port
        Where it listens.
    token : str or None
        What a client must show to change anything; without one nothing can be changed.
    writable : bool
        Whether clients with the token may also update scenes, and write graphs of their own.
    store : Path or None
        Where scenes and graphs are kept; without one they are gone with the server.
    hosts : tuple of str
        Names, beside the address it listens on, by which clients may call it.
    origins : tuple of str
        Web pages' origins that may read answers (CORS); ``*`` for any.
    limits : Limits
    """

    host: str = "127.0.0.1"
    port: int = 7878
    token: str | None = None
    writable: bool = False
    store: Path | None = None
    hosts: tuple[str, ...] = ()
    origins: tuple[str, ...] = ()
    limits: Limits = field(default_factory=Limits)
