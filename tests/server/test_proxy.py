"""Behind a proxy that answers TLS: nginx, by the file of docs/service.md with places and ports of the test."""

import json
import os
import re
import shutil
import socket
import ssl
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from http.client import HTTPConnection, HTTPResponse, HTTPSConnection
from pathlib import Path

import pytest

from tests.support.new_stores import new_file
from tests.support.served import served
from tests.support.service import PASSWORD
from trueloop.jobs.store.codec import store_codec
from trueloop.storage.store import Store, open_store

PAGE = Path(__file__).parents[2] / "docs" / "service.md"
INSTALL = "apt-get install -y --no-install-recommends nginx-light"
NAME = "factory.shop.example"


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = open_store(new_file(tmp_path / "trueloop.db"), codec=store_codec())
    yield opened
    opened.close()


def _free_port() -> int:
    with closing(socket.create_server(("127.0.0.1", 0))) as free:
        return int(free.getsockname()[1])


@contextmanager
def _nginx(folder: Path, service: str) -> Iterator[int]:
    """nginx before the service, at a port of this machine."""
    program = shutil.which("nginx", path="/usr/sbin:/usr/local/sbin:/usr/bin:/usr/local/bin")
    assert program is not None, f"nginx is not installed; run as root:  {INSTALL}"
    made = ("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1", "-subj", f"/CN={NAME}")
    names = ("-addext", f"subjectAltName=DNS:{NAME}", "-keyout", "key.pem", "-out", "chain.pem")
    subprocess.run([*made, *names], cwd=folder, check=True, capture_output=True, timeout=60)
    found = re.search(r"```nginx\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    port = _free_port()
    server = found[1].replace("443 ssl", f"127.0.0.1:{port} ssl").replace("/etc/ssl/factory", str(folder))
    server = server.replace("http://127.0.0.1:8080", service)
    paths = "".join(
        f"{one}_temp_path {folder}/{one};\n" for one in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    )
    http = f"http {{\naccess_log off;\n{paths}{server}}}\n"
    (folder / "nginx.conf").write_text(f"daemon off;\npid {folder}/pid;\nevents {{}}\n{http}")
    log = folder / "error.log"
    running = subprocess.Popen(
        [program, "-p", folder, "-c", "nginx.conf", "-e", log, "-g", "user root;" * (os.geteuid() == 0)]
    )
    try:
        for _ in range(200):
            with socket.socket() as tried:
                if tried.connect_ex(("127.0.0.1", port)) == 0:
                    break
            assert running.poll() is None, log.read_text()
            time.sleep(0.05)
        yield port
    finally:
        running.terminate()
        running.wait(20)


class _ToNginx(HTTPSConnection):
    """A browser for which the name leads to this machine."""

    def connect(self) -> None:
        plain = socket.create_connection(("127.0.0.1", self.port), 20)
        self.sock = self._context.wrap_socket(plain, server_hostname=self.host)  # type: ignore[attr-defined]


def _asked(
    browser: HTTPConnection, method: str, path: str, said: object = None, **headers: str
) -> tuple[HTTPResponse, bytes]:
    body = None if said is None else json.dumps(said).encode()
    given = {name.replace("_", "-"): value for name, value in headers.items()}
    browser.request(method, f"/api/v1/{path}", body, {"Content-Type": "application/json", **given})
    answer = browser.getresponse()
    return answer, answer.read()


def test_behind_nginx_people_sign_in_as_over_tls(store: Store, tmp_path: Path) -> None:
    right = {"name": "operator", "password": PASSWORD}
    with served(store, proxies=("127.0.0.1",), names=(NAME,)) as address, _nginx(tmp_path, address) as port:
        context = ssl.create_default_context(cafile=tmp_path / "chain.pem")
        origin = f"https://{NAME}:{port}"
        with closing(_ToNginx(NAME, port, context=context)) as browser:
            answer, _ = _asked(browser, "POST", "session", right, Origin=origin)
            assert answer.status == 200
            cookie = answer.headers["set-cookie"]
            assert cookie.startswith("__Host-session=") and "secure" in cookie.casefold()
            assert answer.headers["strict-transport-security"]
            answer, said = _asked(browser, "GET", "me", Cookie=cookie.partition(";")[0])
            assert answer.status == 200 and json.loads(said)["name"] == "operator"
            for wrong in (f"http://{NAME}:{port}", "https://evil.example", f"https://{NAME}"):
                answer, said = _asked(browser, "POST", "session", right, Origin=wrong)
                assert answer.status == 403 and json.loads(said)["code"] == "SRV-ORIGIN"


def test_delays_are_of_the_client_and_not_of_the_proxy(store: Store) -> None:
    """The proxy's own word, as nginx passes it on: 20 wrong guesses of one address do not lock another's out."""
    with served(store, proxies=("127.0.0.1",), names=(NAME,)) as address:
        host, port = address.removeprefix("http://").split(":")
        with closing(HTTPConnection(host, int(port), timeout=20)) as proxy:

            def sign_in(client: str, name: str, password: str) -> int:
                said = {"name": name, "password": password}
                headers = {"Host": NAME, "Origin": f"https://{NAME}", "X_Forwarded_For": client}
                return _asked(proxy, "POST", "session", said, **headers)[0].status

            assert [sign_in("192.0.2.7", f"n{k}", "wrong wrong wrong") for k in range(22)] == [401] * 20 + [429] * 2
            assert sign_in("192.0.2.8", "operator", PASSWORD) == 200


def test_an_address_that_a_client_claims_is_not_believed(store: Store) -> None:
    """Without a proxy that is trusted: 20 wrong guesses lock, whatever addresses they claim to come from."""
    with served(store) as address:
        host, port = address.removeprefix("http://").split(":")
        with closing(HTTPConnection(host, int(port), timeout=20)) as client:
            found = [
                _asked(
                    *(client, "POST", "session", {"name": f"n{k}", "password": "wrong wrong wrong"}),
                    Origin=address,
                    X_Forwarded_For=f"192.0.2.{k}",
                )[0].status
                for k in range(21)
            ]
    assert found == [401] * 20 + [429]
