"""The version of lmgcpy, for all who write it into a file."""

VERSION = "0.2.0"
