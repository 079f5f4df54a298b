"""A process that shows documents as a running participant does (base/status_server.hpp): this one."""

import contextlib
import json
import os
import socket
import threading


def document(folder, kind="permissions", name="permissions.p7s", refused=None, until="2027-11-21T00:00:00Z"):
    state = "refused" if refused and refused["stands"] else "current"
    return {"kind": kind, "file": str(folder / name), "state": state, "since": "2026-11-21T00:00:00Z", "more": 0, "waiting": None,
            "refused": refused, "in_force": [{"subject": "CN=talker", "number": "1A", "until": until, "sha256": "ab" * 32}]}


def certificate(folder, **more):
    return document(folder, "identity certificate", "cert.pem", **more)


def refusal(stands=True, waits=False):
    return {"at": "2026-11-21T01:00:00Z", "file": "permissions.p7s", "code": 1436, "name": "permissions_renewal_refused",
            "sentence": "the sentence of the event [permissions_renewal_refused 1436]", "stands": stands,
            "waits": waits}


def participant(folder, *documents, identity=1, guid="0110"):
    return {"identity": identity, "guid": guid, "subject": "CN=talker", "cut_off": None,
            "documents": list(documents) or [certificate(folder), document(folder, refused=refusal())]}


def answer(*participants, left_out=0):
    return json.dumps({"schema": "ddssec-status/1", "pid": os.getpid(), "participants": participants,
                       "left_out": left_out})


@contextlib.contextmanager
def running_participant(status, folder, text=None, pid=None, more=""):
    """`status`: the folder of the socket; `text`: the answer; None: one participant with a refused document."""
    status.mkdir(mode=0o700, exist_ok=True)
    path = status / f"ddssec-{pid or os.getpid()}{more}.sock"
    server = socket.socket(socket.AF_UNIX)
    server.bind(str(path))
    server.listen()
    octets = (answer(participant(folder)) if text is None else text).encode()

    def serve():
        while True:
            try:
                client, _ = server.accept()
            except OSError:
                return
            with client, contextlib.suppress(OSError):
                client.sendall(octets)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield path
    finally:
        server.shutdown(socket.SHUT_RDWR)
        server.close()
        thread.join()
        path.unlink(missing_ok=True)
