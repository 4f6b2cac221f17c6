# SPDX-License-Identifier: BSD-3-Clause
"""A server of one page and of the frames that it shows while they are computed.

It is bound to this machine, and uses server-sent events, for which browsers and Python need no package.
"""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, override

import numpy as np
from numpy.typing import NDArray

from gelenk.viewer.page import packed, page_of

HOST = "127.0.0.1"
MAX_FRAMES = 5000  # that are kept for pages opened later
MAX_CONNECTIONS = 32  # at the same time, each of which needs a thread; pages have two or three
TIMEOUT = 10.0  # s; how long a connection may take to send its request, or to receive a part of an answer
POLL = 1.0  # s; how often a connection without new frames is checked
LINGER = 2.0  # s; how long pages may take to receive the last frames
POLICY = "img-src data:"  # end of the page's content security policy


class LiveServer:
    """Serves the page of a running simulation; frames are added to it."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        """Start to serve `gelenk.viewer.data.page_data` of the start. Raises OSError, UsageError."""
        html = page_of({**data, "live": True})
        self.page = html.replace(POLICY, f"{POLICY}; connect-src 'self'", 1).encode()
        self.changed = threading.Condition()
        self.frames: deque[tuple[float, NDArray[np.float32]]] = deque(maxlen=MAX_FRAMES)
        #: Number of frames that have been added, of the connections that are open, and of all there were.
        self.count = self.open = self.opened = 0
        self.ended = False
        self._server = _Server((HOST, 0), _handler(self))
        self._thread = threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": 0.1}, daemon=True
        )
        self._thread.start()

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self._server.server_address[1]}/"

    def add(self, time: float, numbers: NDArray[np.float32]) -> None:
        """Add a frame: its time [s], and the poses of the bodies followed by the signals."""
        with self.changed:
            self.frames.append((time, numbers))
            self.count += 1
            self.changed.notify_all()

    def batch(self, sent: int) -> tuple[int, str]:
        """Wait for frames after the first `sent` ones; return how many there are then, and a message."""
        with self.changed:
            if self.count == sent and not self.ended:
                self.changed.wait(POLL)
            new = min(self.count - sent, len(self.frames))
            frames = [self.frames[k] for k in range(len(self.frames) - new, len(self.frames))]
            count, ended = self.count, self.ended
        if not frames:
            return count, "event: end\ndata: {}\n\n" if ended else ": still there\n\n"
        times = np.array([t for t, _ in frames])
        content = {"time": packed(times), "numbers": packed(np.array([numbers for _, numbers in frames]))}
        return count, f"data: {json.dumps(content)}\n\n"

    def close(self, first: float = 0.0) -> None:
        """Send the last frames and stop to serve.

        Args:
            first: how long to wait for a page that has not yet been opened [s].
        """
        with self.changed:
            self.ended = True
            self.changed.notify_all()
        start = time.monotonic()
        while (not self.opened and time.monotonic() < start + first) or (
            self.open and time.monotonic() < start + first + LINGER
        ):
            time.sleep(0.02)
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Server(ThreadingHTTPServer):
    """A server that closes connections in excess at once."""

    daemon_threads = True
    # Connections waiting to be accepted. Beyond these, the system drops the last packet of a handshake: the
    # browser takes itself for connected, but hears from the server only seconds later, or never.
    request_queue_size = 128

    def __init__(self, *arguments: Any) -> None:
        self._free = threading.BoundedSemaphore(MAX_CONNECTIONS)
        super().__init__(*arguments)

    @override
    def process_request(self, request: Any, client_address: Any) -> None:
        if not self._free.acquire(blocking=False):
            self.shutdown_request(request)
            return
        try:
            super().process_request(request, client_address)
        except BaseException:  # no thread can be started
            self._free.release()
            raise

    @override
    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()


def _handler(live: LiveServer) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        timeout = TIMEOUT

        def do_GET(self) -> None:
            # A page of another site, whose name was made to point here, sends that name.
            if self.headers.get("Host") != live.url.split("/")[2]:
                self.send_error(HTTPStatus.FORBIDDEN)
            elif self.path == "/":
                self.begin("text/html; charset=utf-8")
                self.wfile.write(live.page)
            elif self.path == "/frames":
                self.begin("text/event-stream")
                self.send_frames()
            else:
                self.send_error(HTTPStatus.NOT_FOUND)

        def begin(self, content: str) -> None:
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", content)
            self.send_header("Cache-Control", "no-store")
            self.end_headers()

        def send_frames(self) -> None:
            with live.changed:
                live.open += 1
                live.opened += 1
            try:
                sent, message = 0, ""
                while not message.startswith("event: end"):
                    sent, message = live.batch(sent)
                    self.wfile.write(message.encode())
                    self.wfile.flush()
            except OSError:
                pass  # the page has been closed
            finally:
                with live.changed:
                    live.open -= 1

        def log_message(self, *_: object) -> None:
            pass

    return Handler
