"""Finished runs: provenance, checksums, comparison, verification, archives."""
