"""Version of the program."""


def installed_version() -> str:
    """The version of the package, looked up only when somebody asks."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("riglens")
    except PackageNotFoundError:
        return "not installed as a package"
