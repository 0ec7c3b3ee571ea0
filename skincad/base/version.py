"""The package's version, which every manifest tells."""

__version__ = "0.1.0"
