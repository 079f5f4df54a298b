"""A server of EST (RFC 7030) that only renews: it signs each request with the CA of `init`."""

import base64
import http.server
import secrets
import ssl
import subprocess
import threading

PATH = "/.well-known/est"


def openssl(*words, octets=b""):
    return subprocess.run(["openssl", *map(str, words)], input=octets, capture_output=True, timeout=60, check=True).stdout


class EstServer:
    """With `has_tls`, clients must have a certificate of the CA; then `certificate` is the file with the server's."""

    def __init__(self, at, ca, has_tls=False):
        self.ca, self.subjects, self.refuses = ca, [], False
        self.certificate, key = at / "est.pem", at / "est.key"
        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), self._handler())
        if has_tls:
            openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj",
                    "/CN=localhost", "-addext", "subjectAltName=DNS:localhost", "-keyout", key, "-out", self.certificate)
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(self.certificate, key)
            context.load_verify_locations(ca / "ca.pem")
            context.verify_mode = ssl.CERT_REQUIRED
            self._server.socket = context.wrap_socket(self._server.socket, server_side=True)
        self.url = f"http{'s' if has_tls else ''}://localhost:{self._server.server_port}{PATH}"
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    def close(self):
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def certs_only(self, request):
        """The answer to a request (DER): a PKCS#7 with the certificate."""
        signed = openssl("x509", "-req", "-inform", "DER", "-sha256", "-days", "400", "-CA", self.ca / "ca.pem", "-CAkey",
                         self.ca / "ca.key.pem", "-set_serial", f"0x4{secrets.token_hex(15)}", octets=request)
        return openssl("crl2pkcs7", "-nocrl", "-certfile", "/dev/stdin", "-outform", "DER", octets=signed)

    def _handler(self):
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                is_fit = (self.path, self.headers["Content-Type"]) == (PATH + "/simplereenroll", "application/pkcs10")
                if outer.refuses or not is_fit:
                    return self.send_error(403)
                peer = self.connection.getpeercert() if isinstance(self.connection, ssl.SSLSocket) else {}
                outer.subjects.append(peer.get("subject"))
                answer = base64.encodebytes(outer.certs_only(base64.b64decode(body)))
                self.send_response(200)
                self.send_header("Content-Type", "application/pkcs7-mime; smime-type=certs-only")
                self.send_header("Content-Transfer-Encoding", "base64")
                self.send_header("Content-Length", str(len(answer)))
                self.end_headers()
                self.wfile.write(answer)

            def log_message(self, *_):
                pass
        return Handler
