# SPDX-License-Identifier: MIT
"""The keys (CURVE) with which a client connects to a server that asks for some, from files as acus-keygen writes them.

The rules are those of protocol/key_file.h.
"""

import os

import zmq
import zmq.auth

from .errors import KeyFileError

OPEN_TO_OTHERS = 0o037  # bits of a mode: at most a group may read a secret


class Keys:
    """The server's public key, and this client's pair. Raises KeyFileError."""

    def __init__(self, server_file, client_file):
        self.server = read_public_key(server_file)
        self.public, self.secret = read_pair(client_file)

    def give_to(self, socket):
        """Before it connects."""
        socket.curve_serverkey, socket.curve_publickey, socket.curve_secretkey = self.server, self.public, self.secret


def read(path):
    """Public and secret key, the latter None where there is none."""
    try:
        return zmq.auth.load_certificate(path)
    except OSError as error:
        raise KeyFileError(f"the key file '{path}' cannot be read") from error
    except (ValueError, IndexError) as error:
        raise KeyFileError(f"the key file '{path}' holds no public key") from error


def public_key_of(path, secret):
    """Of any 32 bytes in Z85, so that it tells whether a key is one, too."""
    try:
        return zmq.curve_public(secret)
    except (ValueError, zmq.ZMQError) as error:
        raise KeyFileError(f"the key file '{path}': expected keys of 40 characters of Z85 in quotes") from error


def read_public_key(path):
    public, secret = read(path)
    if secret is not None:
        raise KeyFileError(f"the key file '{path}' holds a secret key, which only its owner needs; give the public "
                           "part")
    public_key_of(path, public)
    return public


def read_pair(path):
    public, secret = read(path)
    if secret is None:
        raise KeyFileError(f"the key file '{path}' holds no secret key; acus-keygen NAME writes one into "
                           "NAME.key_secret")
    if os.stat(path).st_mode & OPEN_TO_OTHERS:
        raise KeyFileError(f"the key file '{path}' holds a secret key and is open to others; chmod 600 '{path}'")
    if public_key_of(path, secret) != public:
        raise KeyFileError(f"the key file '{path}': the public key is not that of the secret key")
    return public, secret
