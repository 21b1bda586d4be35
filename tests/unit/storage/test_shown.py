"""Passwords of databases are in no message, no name of a store and no output, wherever they stand in a URL."""

from urllib.parse import quote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.cli import output_of
from trueloop.cli.terminal import ExitStatus
from trueloop.errors import Code, TrueloopError
from trueloop.storage.keeping import shown
from trueloop.storage.store import open_store

SECRET = "hunter2"
URLS = (
    "postgresql://ana:hunter2@127.0.0.1:1/parts",
    "postgresql://:hunter2@127.0.0.1:1/parts",
    "postgresql://ana:x@hunter2@127.0.0.1:1/parts",
    "postgresql://ana@plant:hunter2@127.0.0.1:1/parts",
    "postgresql://ana:x/hunter2@127.0.0.1:1/parts",
    "postgresql://ana:x?hunter2@127.0.0.1:1/parts",
    "postgresql://ana:hunter2@127.0.0.1:port/parts",
    "postgresql://ana@127.0.0.1:1/parts?password=hunter2",
    "postgresql://ana@127.0.0.1:1/parts?connect_timeout=1&PassWord=hunter2",
    "postgresql://ana@127.0.0.1:1/parts?sslpassword=hunter2&connect_timeout=1",
    "postgresql://ana@127.0.0.1:1/parts?pass%77ord=hunter2",
    "mysql://ana:hunter2@127.0.0.1:1/parts",
    "parts://ana@127.0.0.1:1/parts?password=hunter2",
)


@pytest.mark.parametrize("url", URLS)
def test_a_refusal_does_not_hold_the_password(url: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        open_store(url)
    error = refused.value
    assert error.code is Code.STO_FILE
    assert SECRET not in f"{error} {error.hint} {error.values} {error.place}"


@pytest.mark.parametrize("url", [URLS[0], URLS[7]])
@pytest.mark.parametrize(
    "command", [("db", "find", "part", "--db"), ("db", "init"), ("db", "export", "-o", "all.jsonl", "--db")]
)
def test_no_command_prints_it(command: tuple[str, ...], url: str) -> None:
    said = output_of(*command, url, status=ExitStatus.REFUSED)
    assert "STO-FILE" in said and "127.0.0.1" in said and SECRET not in said


@given(st.text(st.characters(codec="ascii"), min_size=4, max_size=20))
def test_any_password_is_hidden_and_the_rest_is_not(password: str) -> None:
    written = quote(password, safe="")
    before = shown(f"postgresql://ana:{written}@plant:5432/parts?sslmode=require")
    assert before == "postgresql://ana:***@plant:5432/parts?sslmode=require"
    query = shown(f"postgresql://ana@plant/parts?password={written}&sslmode=require")
    assert query == "postgresql://ana@plant/parts?password=***&sslmode=require"


@pytest.mark.parametrize(
    "place", ["trueloop.db", "a:b@c.db", "postgresql://ana@plant:5432/parts?sslmode=require", "sqlite:///trueloop.db"]
)
def test_what_holds_no_password_is_shown_whole(place: str) -> None:
    assert shown(place) == place
