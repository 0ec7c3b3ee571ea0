"""The silicone as tested: its modulus from a pressed pad or a pulled bar."""
