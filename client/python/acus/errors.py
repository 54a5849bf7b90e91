# SPDX-License-Identifier: MIT
"""What goes wrong, by kind. The names of the first four are those of the C++ client (client/link/client.h)."""


class AcusError(Exception):
    """Any trouble that the package tells of; str() is a sentence for people."""


class ClientError(AcusError):
    """With a connection; names the endpoint."""


class Vanished(ClientError):
    """Nobody answered in time: there is no server at the endpoint, or it went away."""


class ProtocolMismatch(ClientError):
    """Somebody answered, but does not speak this version of the protocol."""


class Refused(ClientError):
    """The server rejected a message: `code` and `message` as protocol/README.md lists them, `rejected` its type."""

    def __init__(self, code, message, rejected=None):
        super().__init__(f"the server refused '{rejected or 'message'}' ({code}): {message}")
        self.code = code
        self.message = message
        self.rejected = rejected

    def __reduce__(self):
        """On its way from one process to another, as out of a pool's."""
        return type(self), (self.code, self.message, self.rejected)


class KeysRefused(Vanished):
    """A server is there, and does not admit this client: its keys are unknown, missing, or too many."""


class KeyFileError(AcusError):
    """Names the file and what is wrong, and never a secret key."""


class ServerFailed(AcusError):
    """acus-server did not start, or ended: `status` is its exit status, `log` what it wrote."""

    def __init__(self, message, status=None, log=""):
        super().__init__(message)
        self.status = status
        self.log = log


class ProgramNotFound(AcusError):
    """A program of Acus that is not where it is looked for."""


class SceneError(AcusError):
    """A scene that cannot be read or used; names the field."""


class RunError(AcusError):
    """A recorded run that cannot be read; names the file."""


class EnvError(AcusError, ValueError):
    """An environment is used as it cannot be; says what to do instead."""


class StudyError(AcusError):
    """A study that cannot be made, run or continued; names the parameter, output or file."""


class FitError(AcusError):
    """Parameters cannot be fitted; names the data, the parameter or the argument and says what to change."""


class PlanError(AcusError):
    """A plan cannot be made; names the argument and says what to change."""
