"""The package's version, which every manifest states."""

__version__ = "0.1.0"
