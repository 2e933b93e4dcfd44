"""Every error that the toolkit raises on purpose, with the exit code that the command line gives it."""


class IndoorBimError(Exception):
    """Base of all errors raised on purpose; its message is complete and meant for the user."""

    exit_code = 1


class ConfigError(IndoorBimError):
    """A parameter, option or configuration file is wrong."""

    exit_code = 2


class ReadError(IndoorBimError):
    """An input file is missing, damaged, empty or of an unknown kind."""

    exit_code = 3


class NothingToReconstructError(IndoorBimError):
    """The input was read, but holds no building that could be modelled.

    Parameters
    ----------
    message : str
        What was found, what was expected and what to do.
    """

    exit_code = 4


class WriteError(IndoorBimError):
    """An output could not be written."""

    exit_code = 2


class ValidationError(IndoorBimError):
    """A file was checked and does not hold what its schema or rules ask for."""

    exit_code = 5
