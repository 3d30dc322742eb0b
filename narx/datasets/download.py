"""Location of a source's recordings: the user's folder, or downloaded once and checked."""

from collections.abc import Iterable
from pathlib import Path

import pooch

from narx.datasets.registry import PUBLIC
from narx.errors import RecordingError, UserError
from narx.files import sha256_of


def find_recordings(name: str, root: str | Path | None) -> Path:
    """Find the folder of a source, downloading it into the user's cache if necessary.

    Parameters
    ----------
    name : str
        A source in `narx.datasets.registry.PUBLIC`.
    root : path-like or None
        Folder of the recordings in their original form. None, or a folder that
        does not exist, means the download cache.

    Returns
    -------
    pathlib.Path
        Folder that exists.

    Raises
    ------
    UserError
        If the recordings are missing and cannot be downloaded, or a downloaded file differs from
        the published one.
    """
    folder = Path(root).expanduser() if root is not None else None
    if folder is not None and folder.is_dir():
        return folder
    return download(name, missing=folder)


def download(name: str, *, missing: Path | None = None) -> Path:
    """Download a public source once, each file checked by SHA-256.

    Parameters
    ----------
    name : str
        A source in `narx.datasets.registry.PUBLIC`.
    missing : pathlib.Path, optional
        Folder that was searched before, for the message.

    Returns
    -------
    pathlib.Path
        ``<user's cache>/narx/<name>``, complete.

    Raises
    ------
    UserError
        If a file is not available, or differs from the published one.
    """
    public = PUBLIC[name]
    folder = Path(pooch.os_cache("narx")) / name
    cache = pooch.create(path=folder, base_url=public.url, registry=public.sha256)
    looked_at = f"no folder '{missing}', and " if missing is not None else ""
    for file in cache.registry:
        try:
            cache.fetch(file)
        except (OSError, ValueError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise UserError(
                f"{name}: {looked_at}'{file}' could not be downloaded from {public.url} "
                f"({reason[:120]}); put the published files into '{folder}', or set "
                f"data_root=DIR with the files in DIR/{name}"
            ) from error
    return folder


def checked_sources(
    name: str, folder: Path, files: Iterable[Path], *, own: Iterable[Path] = ()
) -> dict[str, str]:
    """Compute the SHA-256 of files, and refuse a file that differs from the published one.

    Parameters
    ----------
    name : str
        Name of the source.
    folder : pathlib.Path
        The source's folder.
    files : iterable of pathlib.Path
        Files below it; those without a published digest are accepted.
    own : iterable of pathlib.Path
        Further files below it, which a user may have replaced by their own of the same name.

    Returns
    -------
    dict of str to str
        Path below the folder, with slashes, to 64 hexadecimal digits.

    Raises
    ------
    RecordingError
        If a published file has different content: it was truncated or edited.
    """
    digests = {}
    published = PUBLIC[name].sha256 if name in PUBLIC else {}
    for file in files:
        relative = file.relative_to(folder).as_posix()
        digests[relative] = sha256_of(file)
        expected = published.get(relative, digests[relative])
        if digests[relative] != expected:
            raise RecordingError(
                f"{file}: not as published (SHA-256 {digests[relative][:12]}..., expected "
                f"{expected[:12]}...): cut off or edited; get the file anew"
            )
    return digests | {file.relative_to(folder).as_posix(): sha256_of(file) for file in own}
