"""Files are downloaded once and verified; without a network the error says what to do."""

import hashlib
import re
from pathlib import Path

import pooch
import pytest

from narx.datasets import download
from narx.datasets.registry import PUBLIC, PublicRecordings
from narx.errors import RecordingError, UserError


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setattr(pooch, "os_cache", lambda name: tmp_path / "cache" / name)
    return tmp_path / "cache" / "narx"


@pytest.fixture
def published(tmp_path, monkeypatch):
    """A source of two files, published in a local folder."""
    upstream = tmp_path / "upstream"
    (upstream / "deep").mkdir(parents=True)
    contents = {"a.txt": b"one\n", "deep/b.txt": b"two\n"}
    for name, content in contents.items():
        (upstream / name).write_bytes(content)
    hashes = {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}
    monkeypatch.setitem(
        PUBLIC, "made", PublicRecordings(f"https://example.invalid/{upstream.name}/", "MIT", hashes)
    )

    def fetch(url, output_file, pooch):
        fetch.calls.append(url)
        name = url.split(f"{upstream.name}/", 1)[1]
        Path(output_file).write_bytes((upstream / name).read_bytes())

    fetch.calls = []
    monkeypatch.setattr("pooch.core.choose_downloader", lambda url, progressbar: fetch)
    fetch.folder = upstream
    return fetch


def test_a_folder_that_is_there_is_used(tmp_path):
    assert download.find_recordings("broad", tmp_path) == tmp_path


def test_downloaded_once_and_whole(cache, published):
    folder = download.find_recordings("made", None)
    assert folder == cache / "made"
    assert (folder / "deep" / "b.txt").read_bytes() == b"two\n"
    assert len(published.calls) == 2
    download.find_recordings("made", None)
    assert len(published.calls) == 2


def test_something_else_than_was_published_is_refused(cache, published):
    (published.folder / "a.txt").write_bytes(b"changed\n")
    with pytest.raises(UserError, match=r"'a\.txt' could not be downloaded"):
        download.find_recordings("made", None)


def test_without_a_network_the_message_names_folder_and_option(cache, published, tmp_path):
    (published.folder / "a.txt").unlink()
    with pytest.raises(UserError) as caught:
        download.find_recordings("made", tmp_path / "nowhere")
    message = str(caught.value)
    assert "\n" not in message
    assert str(tmp_path / "nowhere") in message
    assert str(cache / "made") in message
    assert "data_root=DIR" in message


def test_files_that_differ_from_the_published_ones_are_refused(published):
    folder = published.folder
    (folder / "mine.txt").write_bytes(b"mine\n")
    sources = download.checked_sources("made", folder, [folder / "a.txt", folder / "mine.txt"])
    assert set(sources) == {"a.txt", "mine.txt"}
    (folder / "deep" / "b.txt").write_bytes(b"tw")
    with pytest.raises(RecordingError, match="not as published"):
        download.checked_sources("made", folder, [folder / "deep" / "b.txt"])


@pytest.mark.parametrize("name", ["smartphone_pocket", "neura_sample", "joint_1to3dof", "broad"])
def test_addresses_are_pinned_and_hashes_are_hashes(name):
    public = PUBLIC[name]
    assert re.fullmatch(
        r"https://raw\.githubusercontent\.com/[^/]+/[^/]+/[0-9a-f]{40}/.*/", public.url
    )
    assert public.sha256
    assert all(re.fullmatch(r"[0-9a-f]{64}", digest) for digest in public.sha256.values())


@pytest.mark.recordings
@pytest.mark.parametrize("name", ["smartphone_pocket", "neura_sample", "joint_1to3dof", "broad"])
def test_hashes_are_those_of_the_recordings(name, data_root):
    if not (data_root / name).is_dir():
        pytest.skip(f"no {name}")
    folder = data_root / name
    # a folder may hold only some of the published files
    present = {file for file in PUBLIC[name].sha256 if (folder / file).is_file()}
    assert present
    assert set(download.checked_sources(name, folder, [folder / f for f in present])) == present
