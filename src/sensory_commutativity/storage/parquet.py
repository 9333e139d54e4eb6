"""Parquet files from elsewhere: read within bounds, and hashed by what was read.

A column of a few bytes can stand for any number of rows, and a dictionary of one long text for any
number of copies of it. Sizes are therefore checked before the rows are read, and texts stay
dictionaries until the size of the plain column is known.
"""

from __future__ import annotations

import hashlib

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

MAX_CELLS = 20_000_000
"""Rows times columns; chosen: nine times the largest table of the paper's sizes."""
MAX_TEXT_BYTES = 300_000_000
"""Bytes of all texts of a table, and of everything that is decompressed; chosen: a table within
MAX_CELLS stays below it, and below 1 GB of memory."""
MAX_COLUMNS = 100
"""Chosen: four times the columns of our widest table."""
ENCODINGS = {"PLAIN", "RLE", "RLE_DICTIONARY", "PLAIN_DICTIONARY", "BIT_PACKED"}
"""Encodings whose decoded size is bounded as above; those that we write."""


class TableTooLargeError(ValueError):
    """A table would take more memory than any of ours."""


def read_bounded_table(content: bytes) -> pa.Table:
    """Read the content of a Parquet file of flat columns.

    Raises
    ------
    TableTooLargeError
        If the table has more rows or longer texts than the limits above.
    pyarrow.ArrowException, OSError
        If the file is damaged.
    """
    with pq.ParquetFile(pa.BufferReader(content)) as file:
        _check_size(file.metadata)
        texts = [field.name for field in file.schema_arrow if pa.types.is_string(field.type)]
    options = dict(read_dictionary=texts, page_checksum_verification=True)
    with pq.ParquetFile(pa.BufferReader(content), **options) as file:
        table = file.read(use_threads=False)
    total = 0
    for name in texts:
        total += _text_bytes(table.column(name))
        if total > MAX_TEXT_BYTES:
            raise TableTooLargeError(f"its texts have more than {MAX_TEXT_BYTES:,} bytes")
    for i, field in enumerate(table.schema):
        if pa.types.is_dictionary(field.type):
            plain = field.with_type(pa.string())
            table = table.set_column(i, plain, table.column(i).cast(pa.string()))
    return table


def _check_size(metadata: pq.FileMetaData) -> None:
    cells = metadata.num_rows * metadata.num_columns
    if metadata.num_columns > MAX_COLUMNS or cells > MAX_CELLS:
        raise TableTooLargeError(
            f"it declares {metadata.num_rows:,} rows of {metadata.num_columns} columns, and at "
            f"most {MAX_CELLS:,} values are read"
        )
    total = 0
    for i in range(metadata.num_row_groups):
        group = metadata.row_group(i)
        for k in range(group.num_columns):
            column = group.column(k)
            total += column.total_uncompressed_size
            unknown = set(column.encodings) - ENCODINGS
            if unknown:
                raise TableTooLargeError(f"it has columns encoded as {', '.join(sorted(unknown))}")
    if total > MAX_TEXT_BYTES:
        raise TableTooLargeError(f"it declares {total:,} bytes of data")


def _text_bytes(column: pa.ChunkedArray) -> int:
    """Bytes of a column of dictionaries once it is plain."""
    total = 0
    for chunk in column.chunks:
        lengths = pc.binary_length(chunk.dictionary)
        total += pc.sum(lengths.take(chunk.indices)).as_py() or 0
    return total


def hash_rows(table: pa.Table) -> str:
    """SHA-256 of the names, types and values of all columns, hexadecimal.

    It does not depend on how the rows are cut into groups, pages or chunks.
    """
    digest = hashlib.sha256()
    for name, column in zip(table.schema.names, table.columns, strict=True):
        digest.update(f"{name} {column.type} {len(column)} {column.null_count}\n".encode())
        if column.null_count:
            digest.update(np.packbits(column.is_null().to_numpy()).tobytes())
        if pa.types.is_string(column.type):
            filled = column.fill_null("") if column.null_count else column
            for part in (pc.binary_length(filled).to_numpy().astype("<i4"), _characters(filled)):
                digest.update(part.tobytes() if isinstance(part, np.ndarray) else part)
        else:
            zero = pa.scalar(0).cast(column.type)
            values = (column.fill_null(zero) if column.null_count else column).to_numpy()
            digest.update(np.ascontiguousarray(values).astype(values.dtype.newbyteorder("<"))
                          .tobytes())  # fmt: skip
    return digest.hexdigest()


def _characters(column: pa.ChunkedArray) -> bytes:
    """All texts of a column without nulls, one after another, as UTF-8."""
    joined = b""
    for chunk in column.chunks:
        _, offsets, data = chunk.buffers()
        if data is None or not len(chunk):
            continue
        bounds = np.frombuffer(offsets, np.int32)[chunk.offset : chunk.offset + len(chunk) + 1]
        joined += data.to_pybytes()[bounds[0] : bounds[-1]]
    return joined
