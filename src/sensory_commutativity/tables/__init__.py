"""The output tables: their columns, types and units, and how they are written and read.

A table is tidy: one row per thing counted. Units and provenance stand in the Parquet file's own metadata. A file is written under a temporary name
and renamed, so that whatever has its final name is complete.
"""

from .files import TABLES, read_about, read_table, schema, write_table, written_whole

__all__ = ["TABLES", "read_about", "read_table", "schema", "write_table", "written_whole"]
