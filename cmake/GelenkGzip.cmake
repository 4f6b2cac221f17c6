# SPDX-License-Identifier: BSD-3-Clause
# cmake -DFILE=... -P GelenkGzip.cmake: writes FILE.gz with CMake's own compressor.
file(ARCHIVE_CREATE OUTPUT ${FILE}.gz PATHS ${FILE} FORMAT raw COMPRESSION GZip COMPRESSION_LEVEL 9)
