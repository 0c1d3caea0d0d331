"""Version of the program."""


def installed_version() -> str:
    """Return the version of the package, looked up at the first call."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("riglens")
    except PackageNotFoundError:
        return "not installed as a package"
