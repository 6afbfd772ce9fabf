"""Parts sailed on other machines by Dask, the one file that knows it; what a lost worker did is done by another."""

from __future__ import annotations

import contextlib
import importlib
import logging
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from fleet.errors import FleetError, UsageError
from fleet.sim.sweep.family import loads
from fleet.sim.sweep.parts import Part, laws_digest, pack, sail
from fleet.sim.sweep.pool import Engine, Sailed

CONNECT_S = 10
_LOCAL = re.compile(r"local:([1-9]\d{0,2})")
_ADDRESS = re.compile(r"(tcp|tls|ws|wss)://\S+:\d{1,5}")


def dask(address: str, started: Callable[[int], None] = lambda pid: None) -> Engine:
    """An engine of a Dask cluster.

    Args:
        address: of its scheduler, `tcp://10.0.0.5:8786`; or `local:N`, N processes here
        started: told the id of each process of a local cluster

    Raises:
        UsageError: that is no address, or Dask is not installed
    """
    if not _LOCAL.fullmatch(address) and not _ADDRESS.fullmatch(address):
        raise UsageError(f"--dask {address}: expected local:N, or the scheduler such as tcp://10.0.0.5:8786")
    try:
        distributed: Any = importlib.import_module("distributed")
    except ImportError:
        raise UsageError('--dask needs Dask, which is not installed: pip install "fleet-usv[dask]"') from None

    def engine(text: str, seed: int, parts: Sequence[Part]) -> Iterator[Sailed]:
        with contextlib.ExitStack() as stack:
            client = _client(distributed, address, stack, started)
            futures = {client.submit(_sailed, text, seed, part, laws_digest(), pure=False): part for part in parts}
            for future in distributed.as_completed(futures):
                part = futures.pop(future)
                try:
                    yield Sailed(part, future.result())
                except Exception as error:  # noqa: BLE001  whatever happened there, the other parts go on
                    yield Sailed(part, None, f"{type(error).__name__}: {error}")
                future.release()

    return engine


def _client(distributed: Any, address: str, stack: contextlib.ExitStack, started: Callable[[int], None]) -> Any:
    """A client that waits for its cluster; the stack ends what is ours."""
    match = _LOCAL.fullmatch(address)
    if match is not None:
        cluster = stack.enter_context(
            distributed.LocalCluster(
                n_workers=int(match[1]),
                threads_per_worker=1,
                processes=True,
                memory_limit=0,
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
            )
        )
        client = stack.enter_context(distributed.Client(cluster))
        for worker in cluster.workers.values():
            started(worker.process.pid)
        return client
    try:
        client = stack.enter_context(distributed.Client(address, timeout=CONNECT_S))
    except (OSError, TimeoutError) as error:
        raise FleetError(f"--dask {address}: no scheduler answers within {CONNECT_S} s: {error}") from None
    try:
        client.wait_for_workers(1, timeout=CONNECT_S)
    except TimeoutError:
        raise FleetError(f"--dask {address}: the scheduler has no worker; expected at least one") from None
    return client


def _sailed(text: str, seed: int, part: Part, laws: str) -> bytes:
    """A part sailed by a worker, whose laws must be those of the sweep."""
    if laws_digest() != laws:
        raise FleetError(f"the worker has laws {laws_digest()}, expected {laws}: install the same fleet everywhere")
    return pack(sail(loads(text), seed, part))
